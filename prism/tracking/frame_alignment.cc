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
                 const PosePrior* prior,
                 AlignmentState* state,
                 std::vector<double>* rho) {
  const bool free_depths = level < options.free_depth_levels;
  const auto with_widening = [&](double widening) {
    return LevelAlignment(reference, target[level], level, noise, options.level, widening, prior);
  };
  const auto has_enough = [](const LevelCost& cost) { return cost.inliers > 0.6 * cost.visible; };
  const LevelAlignment problem = with_widening(1);
  if (has_enough(problem.Evaluate(*state, *rho))) return problem.Align(free_depths, state, rho);

  // Most residuals are large. Either the solution is far: with a threshold so wide that most count
  // it is found, then the threshold is narrowed again. Or most of the view is hidden: what is left
  // says where the frame is. The one with the smaller cost is right.
  AlignmentState far_state = *state;
  std::vector<double> far_rho = *rho;
  double widening = 2;
  while (widening < 16 && !has_enough(with_widening(widening).Evaluate(far_state, far_rho))) {
    widening *= 2;
  }
  int iterations = problem.Align(free_depths, state, rho);
  for (; widening >= 1; widening /= 2) {
    iterations += with_widening(widening).Align(free_depths, &far_state, &far_rho);
  }
  if (problem.Evaluate(far_state, far_rho).PerSample() <
      problem.Evaluate(*state, *rho).PerSample()) {
    *state = far_state;
    *rho = std::move(far_rho);
  }
  return iterations;
}

int NumLevels(const TrackingReference& reference, const ImagePyramid& target) {
  return static_cast<int>(std::min(target.size(), reference.levels.size()));
}

// Projects the pixel's point moved by a motion; false at or behind the centre of projection.
bool ProjectPixel(const ReferencePixel& sample,
                  double rho,
                  const PlenopticProjection& camera,
                  const RigidMotion& motion,
                  Eigen::Vector2d* px) {
  const double k = 1 - rho * camera.center_z();
  const Eigen::Vector3d ray(sample.m.x() * k, sample.m.y() * k, 1);
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
  ForEachPixel(reference.levels[0], [&](const ReferencePixel& pixel, size_t point) {
    const double rho = reference.points[point].rho;
    Eigen::Vector2d start, moved, shifted;
    if (!ProjectPixel(pixel, rho, camera, RigidMotion(), &start) ||
        !ProjectPixel(pixel, rho, camera, motion, &moved) ||
        !ProjectPixel(pixel, rho, camera, translation, &shifted)) {
      return;
    }
    sum += (moved - start).squaredNorm();
    translation_sum += (shifted - start).squaredNorm();
    ++count;
  });
  if (count == 0) return;
  result->squared_flow = sum / count;
  result->squared_translation_flow = translation_sum / count;
}

AlignmentStatus Judge(const FrameAlignmentResult& result, const AlignmentOptions& options) {
  if (!std::isfinite(result.points.rms) || !result.state.target_from_reference.Log().allFinite()) {
    return AlignmentStatus::kDiverged;
  }
  return options.possible.AreMetBy(result.fit) ? AlignmentStatus::kGood : AlignmentStatus::kBadFit;
}

}  // namespace

bool AlignmentOptions::IsValid(std::string* error) const {
  if (level.max_iterations >= 1 && level.huber > 0 && level.outlier > level.huber &&
      level.depth_huber > 0 && level.max_log_gain > 0 && level.max_offset > 0 &&
      free_depth_levels >= 0) {
    return possible.IsValid(error);
  }
  *error =
      "alignment needs an iteration or more, positive Huber thresholds, the photometric one below "
      "the outlier threshold, positive limits of brightness, and 0 levels or more with free depths";
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
  const double num_samples = static_cast<double>(reference.levels[level].count);
  struct Fit {
    AlignmentState state;
    double expected_a;
    double cost;
  };
  const auto align_all = [&](int max_iterations, std::vector<Fit>* fits) {
    AlignmentOptions few = options;
    few.free_depth_levels = 0;
    few.level.max_iterations = std::min(max_iterations, options.level.max_iterations);
    for (auto& [state, expected_a, cost] : *fits) {
      std::vector<double> rho = InverseDepths(reference);
      AlignOnLevel(reference, target, level, noise, few, nullptr, &state, &rho);
      const LevelCost reached = problem.Evaluate(state);
      const bool possible =
          reached.visible >= options.possible.min_visible_fraction * num_samples &&
          std::abs(state.a - expected_a) <= options.possible.max_log_gain;
      cost = possible ? reached.PerSample() : INFINITY;
    }
    std::stable_sort(fits->begin(), fits->end(), [](const Fit& left, const Fit& right) {
      return left.cost < right.cost;
    });
  };
  // A few iterations tell which starts are worth more.
  constexpr int kFirstIterations = 5;
  constexpr size_t kMaxFits = 12;
  std::vector<Fit> fits;
  for (const AlignmentState& start : starts) fits.push_back({start, start.a, 0});
  align_all(kFirstIterations, &fits);
  if (fits.size() > kMaxFits) fits.resize(kMaxFits);
  align_all(options.level.max_iterations, &fits);
  std::vector<AlignmentState> minima;
  for (const Fit& fit : fits) {
    if (std::isinf(fit.cost)) break;
    const auto is_fit = [&](const AlignmentState& minimum) {
      return AreOneMinimum(
          reference, minimum.target_from_reference, fit.state.target_from_reference);
    };
    if (std::none_of(minima.begin(), minima.end(), is_fit)) minima.push_back(fit.state);
  }
  return minima;
}

double FlowBetween(const TrackingReference& reference, const SE3& left, const SE3& right) {
  const PlenopticProjection& camera = reference.cameras.back();
  const RigidMotion motion_left(left), motion_right(right);
  double sum = 0;
  int count = 0;
  ForEachPixel(reference.levels.back(), [&](const ReferencePixel& pixel, size_t point) {
    const double rho = reference.points[point].rho;
    Eigen::Vector2d px_left, px_right;
    if (ProjectPixel(pixel, rho, camera, motion_left, &px_left) &&
        ProjectPixel(pixel, rho, camera, motion_right, &px_right)) {
      sum += (px_left - px_right).squaredNorm();
      ++count;
    }
  });
  return count > 0 ? std::ldexp(std::sqrt(sum / count), reference.NumLevels() - 1) : 0;
}

bool AreOneMinimum(const TrackingReference& reference, const SE3& left, const SE3& right) {
  return FlowBetween(reference, left, right) <= std::ldexp(1.0, reference.NumLevels() - 1);
}

FrameAlignmentResult AlignFrame(const TrackingReference& reference,
                                const ImagePyramid& target,
                                const AlignmentState& initial,
                                const NoiseModel& noise,
                                const AlignmentOptions& options,
                                int coarsest_level,
                                const PosePrior* prior) {
  FrameAlignmentResult result;
  result.state = initial;
  const int num_levels = NumLevels(reference, target);
  if (num_levels == 0 || reference.empty()) {
    result.status = AlignmentStatus::kTooFewPoints;
    return result;
  }
  std::vector<double> rho = InverseDepths(reference);
  for (int level = std::min(num_levels - 1, coarsest_level); level >= 0; --level) {
    result.iterations +=
        AlignOnLevel(reference, target, level, noise, options, prior, &result.state, &rho);
  }
  result.points = JudgePoints(reference, target[0], result.state, rho, noise);
  if (result.points.AreManyHidden()) {
    // What is hidden still pulls at the brightness, below the threshold of outliers.
    TrackingReference seen = reference;
    for (size_t i = 0; i < seen.points.size(); ++i) {
      if (result.points.fits[i] == PointFit::kOutlier) seen.points[i].is_excluded = true;
    }
    result.iterations += AlignOnLevel(seen, target, 0, noise, options, prior, &result.state, &rho);
    result.points = JudgePoints(reference, target[0], result.state, rho, noise);
  }
  result.cost = LevelAlignment(reference, target[0], 0, noise, options.level)
                    .Evaluate(result.state, rho)
                    .PerSample();
  result.fit.rms = result.points.rms / noise.FitSigma();
  result.fit.visible_fraction =
      static_cast<double>(result.points.seen) / static_cast<double>(reference.points.size());
  result.fit.outlier_fraction = result.points.OutlierFraction();
  result.fit.misfit_area = result.points.misfit_area;
  result.fit.log_gain = std::abs(result.state.a - initial.a);
  result.status = Judge(result, options);
  if (result.status == AlignmentStatus::kGood) MeasureFlow(reference, &result);
  result.rho = std::move(rho);
  return result;
}

Matrix6d PoseInformation(const TrackingReference& reference,
                         const ImagePyramid& target,
                         const FrameAlignmentResult& alignment,
                         const NoiseModel& noise,
                         const AlignmentOptions& options,
                         const PosePrior* prior) {
  return LevelAlignment(reference, target[0], 0, noise, options.level, 1, prior)
      .PoseInformation(alignment.state, alignment.rho, options.free_depth_levels > 0);
}

}  // namespace prism
