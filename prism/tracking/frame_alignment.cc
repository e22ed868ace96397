// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/frame_alignment.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prism {
namespace {

std::vector<double> InverseDepths(const TrackingReference& reference) {
  std::vector<double> rho;
  for (const ReferencePoint& point : reference.points) rho.push_back(point.rho);
  return rho;
}

int AlignOnLevel(const TrackingReference& reference,
                 const ImagePyramid& target,
                 int level,
                 const NoiseModel& noise,
                 const AlignmentOptions& options,
                 AlignmentState* state,
                 std::vector<double>* rho) {
  // Far from the solution most residuals are large: widen the threshold until most count.
  double widening = 1;
  for (int doubling = 0; doubling < 4; ++doubling) {
    const LevelCost cost =
        LevelAlignment(reference, target[level], level, noise, options.level, widening)
            .Evaluate(*state, *rho);
    if (cost.inliers > 0.6 * cost.visible) break;
    widening *= 2;
  }
  return LevelAlignment(reference, target[level], level, noise, options.level, widening)
      .Align(level < options.free_depth_levels, state, rho);
}

int NumLevels(const TrackingReference& reference, const ImagePyramid& target) {
  return static_cast<int>(std::min(target.size(), reference.levels.size()));
}

// Projects the sample's point moved by a motion; false at or inside the focal length.
bool ProjectSample(const TrackingReference::Sample& sample,
                   double rho,
                   const PlenopticProjection& camera,
                   const RigidMotion& motion,
                   Eigen::Vector2d* px) {
  const double k = 1 - rho * camera.f;
  const Eigen::Vector3d ray(sample.pixel.m.x() * k, sample.pixel.m.y() * k, 1);
  ScaledProjection::Pixel pixel;
  if (!ScaledProjection(camera).Project(motion.R * ray + rho * motion.t, rho, &pixel)) {
    return false;
  }
  *px = {pixel.x, pixel.y};
  return true;
}

void MeasureFlow(const TrackingReference& reference, FrameAlignmentResult* result) {
  const PlenopticProjection& camera = reference.cameras[0];
  const RigidMotion motion(result->state.target_from_reference);
  RigidMotion translation;
  translation.t = motion.t;
  double sum = 0, translation_sum = 0;
  int count = 0;
  for (const TrackingReference::Sample& sample : reference.levels[0]) {
    const double rho = reference.points[sample.point].rho;
    Eigen::Vector2d start, moved, shifted;
    if (!ProjectSample(sample, rho, camera, RigidMotion(), &start) ||
        !ProjectSample(sample, rho, camera, motion, &moved) ||
        !ProjectSample(sample, rho, camera, translation, &shifted)) {
      continue;
    }
    sum += (moved - start).squaredNorm();
    translation_sum += (shifted - start).squaredNorm();
    ++count;
  }
  if (count == 0) return;
  result->squared_flow = sum / count;
  result->squared_translation_flow = translation_sum / count;
}

AlignmentStatus Judge(const FrameAlignmentResult& result, const AlignmentOptions& options) {
  if (!std::isfinite(result.rms) || !result.state.target_from_reference.Log().allFinite()) {
    return AlignmentStatus::kDiverged;
  }
  return options.possible.AreMetBy(result.fit) ? AlignmentStatus::kGood : AlignmentStatus::kBadFit;
}

}  // namespace

bool AlignmentOptions::IsValid(std::string* error) const {
  if (level.max_iterations >= 1 && level.huber > 0 && level.outlier > level.huber &&
      level.depth_huber > 0 && free_depth_levels >= 0) {
    return possible.IsValid(error);
  }
  *error =
      "alignment needs an iteration or more, positive Huber thresholds, the photometric one below "
      "the outlier threshold, and 0 levels or more with free depths";
  return false;
}

std::vector<AlignmentState> RankStarts(const TrackingReference& reference,
                                       const ImagePyramid& target,
                                       const std::vector<AlignmentState>& starts,
                                       const NoiseModel& noise,
                                       const AlignmentOptions& options) {
  const int num_levels = NumLevels(reference, target);
  if (num_levels == 0 || reference.empty()) return {};
  const int level = num_levels - 1;
  const LevelAlignment problem(reference, target[level], level, noise, options.level);
  const double num_samples = static_cast<double>(reference.levels[level].size());
  using Fit = std::pair<double, AlignmentState>;  // with its cost
  const auto align_all = [&](int max_iterations, std::vector<Fit>* fits) {
    AlignmentOptions few = options;
    few.free_depth_levels = 0;
    few.level.max_iterations = std::min(max_iterations, options.level.max_iterations);
    for (auto& [cost, state] : *fits) {
      std::vector<double> rho = InverseDepths(reference);
      AlignOnLevel(reference, target, level, noise, few, &state, &rho);
      const LevelCost reached = problem.Evaluate(state);
      const bool possible =
          reached.visible >= options.possible.min_visible_fraction * num_samples &&
          std::abs(state.a) <= options.possible.max_log_gain;
      cost = possible ? reached.PerSample() : INFINITY;
    }
    std::stable_sort(fits->begin(), fits->end(), [](const Fit& left, const Fit& right) {
      return left.first < right.first;
    });
  };
  // A few iterations tell which starts are worth more.
  constexpr int kFirstIterations = 5;
  constexpr size_t kMaxFits = 12;
  std::vector<Fit> fits;
  for (const AlignmentState& start : starts) fits.emplace_back(0, start);
  align_all(kFirstIterations, &fits);
  if (fits.size() > kMaxFits) fits.resize(kMaxFits);
  align_all(options.level.max_iterations, &fits);
  std::vector<AlignmentState> minima;
  for (const auto& [cost, fit] : fits) {
    if (std::isinf(cost)) break;
    const auto is_fit = [&, &fit = fit](const AlignmentState& minimum) {
      return AreOneMinimum(reference, minimum.target_from_reference, fit.target_from_reference);
    };
    if (std::none_of(minima.begin(), minima.end(), is_fit)) minima.push_back(fit);
  }
  return minima;
}

bool AreOneMinimum(const TrackingReference& reference, const SE3& left, const SE3& right) {
  constexpr double kSamePx = 1;
  const PlenopticProjection& camera = reference.cameras.back();
  const RigidMotion motion_left(left), motion_right(right);
  double sum = 0;
  int count = 0;
  for (const TrackingReference::Sample& sample : reference.levels.back()) {
    const double rho = reference.points[sample.point].rho;
    Eigen::Vector2d px_left, px_right;
    if (ProjectSample(sample, rho, camera, motion_left, &px_left) &&
        ProjectSample(sample, rho, camera, motion_right, &px_right)) {
      sum += (px_left - px_right).squaredNorm();
      ++count;
    }
  }
  return sum <= kSamePx * kSamePx * count;
}

FrameAlignmentResult AlignFrame(const TrackingReference& reference,
                                const ImagePyramid& target,
                                const AlignmentState& initial,
                                const NoiseModel& noise,
                                const AlignmentOptions& options) {
  FrameAlignmentResult result;
  result.state = initial;
  const int num_levels = NumLevels(reference, target);
  if (num_levels == 0 || reference.empty()) {
    result.status = AlignmentStatus::kTooFewPoints;
    return result;
  }
  std::vector<double> rho = InverseDepths(reference);
  for (int level = num_levels - 1; level >= 0; --level) {
    result.iterations +=
        AlignOnLevel(reference, target, level, noise, options, &result.state, &rho);
    if (level > 0) continue;
    const LevelCost cost =
        LevelAlignment(reference, target[0], 0, noise, options.level).Evaluate(result.state, rho);
    result.inliers = cost.inliers;
    result.rms = cost.inliers > 0 ? std::sqrt(cost.squared_error / cost.inliers) : INFINITY;
    result.fit.rms = result.rms / noise.FitSigma();
    result.fit.visible_fraction = static_cast<double>(cost.visible) / reference.levels[0].size();
    result.fit.outlier_fraction =
        cost.visible > 0 ? 1 - static_cast<double>(cost.inliers) / cost.visible : 1;
    result.fit.log_gain = std::abs(result.state.a);
  }
  result.status = Judge(result, options);
  if (result.status == AlignmentStatus::kGood) MeasureFlow(reference, &result);
  return result;
}

}  // namespace prism
