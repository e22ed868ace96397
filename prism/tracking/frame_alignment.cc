// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/frame_alignment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "prism/image/interpolation.h"
#include "prism/image/patch.h"

namespace prism {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// Robust cost over all samples of a level at one state; samples outside the image cost nothing and
// outliers the same wherever they are, so costs are compared per visible sample.
struct LevelCost {
  double energy = 0;         // sum of weighted robust squares
  double squared_error = 0;  // sum of squared residuals of inliers
  int visible = 0;
  int inliers = 0;
  double PerSample() const { return visible > 0 ? energy / visible : INFINITY; }
};

class LevelProblem {
 public:
  LevelProblem(const std::vector<TrackingReference::Sample>& samples,
               const PlenopticProjection& camera,
               const ImageViewF& image,
               const AlignmentOptions& options,
               double huber_threshold,
               double outlier_threshold)
      : samples_(samples),
        camera_(camera),
        image_(image),
        robust_(options.robust),
        huber_threshold_(huber_threshold),
        outlier_threshold_(outlier_threshold) {}

  // With H and g (gradient of half the energy) over [pose; a; b] if asked for.
  LevelCost Evaluate(const AlignmentState& state, Matrix8d* H, Vector8d* g) const {
    if (H != nullptr) {
      H->setZero();
      g->setZero();
    }
    LevelCost cost;
    const RelativeState relative{state.target_from_reference, std::exp(state.a), state.b};
    const ScaledProjection projection(camera_);
    const double huber = huber_threshold_;
    PixelResidual residual;
    for (const TrackingReference::Sample& sample : samples_) {
      if (!EvaluatePixel(sample.pixel,
                         sample.rho,
                         relative,
                         projection,
                         camera_.f,
                         image_,
                         H != nullptr,
                         &residual)) {
        continue;
      }
      ++cost.visible;
      const double r = residual.value;
      const double magnitude = std::abs(r);
      if (magnitude > outlier_threshold_) {
        cost.energy += sample.pixel.weight * RobustSquare(outlier_threshold_);
        continue;
      }
      ++cost.inliers;
      cost.squared_error += r * r;
      cost.energy += sample.pixel.weight * RobustSquare(magnitude);
      if (H == nullptr) continue;
      const double weight = robust_ && magnitude > huber ? sample.pixel.weight * huber / magnitude
                                                         : sample.pixel.weight;
      const Vector8d& J = residual.J_state;
      const Vector8d weighted = weight * J;
      // Upper triangle only.
      for (int row = 0; row < 8; ++row) {
        for (int column = row; column < 8; ++column) (*H)(row, column) += weighted[row] * J[column];
      }
      *g += weighted * r;
    }
    if (H != nullptr) H->triangularView<Eigen::StrictlyLower>() = H->transpose();
    return cost;
  }

 private:
  double RobustSquare(double magnitude) const {
    const double huber = huber_threshold_;
    if (!robust_ || magnitude <= huber) return magnitude * magnitude;
    return huber * (2 * magnitude - huber);
  }

  const std::vector<TrackingReference::Sample>& samples_;
  const PlenopticProjection& camera_;
  const ImageViewF image_;
  const bool robust_;
  const double huber_threshold_;    // intensities
  const double outlier_threshold_;  // intensities
};

AlignmentState Updated(const AlignmentState& state, const Vector8d& step) {
  AlignmentState updated;
  updated.target_from_reference = SE3::Exp(step.head<6>()) * state.target_from_reference;
  updated.a = state.a + step[6];
  updated.b = state.b + step[7];
  return updated;
}

// Levenberg-Marquardt on one level; returns the number of iterations.
int AlignLevel(const LevelProblem& problem,
               const AlignmentOptions& options,
               AlignmentState* state) {
  Matrix8d H;
  Vector8d g;
  LevelCost cost = problem.Evaluate(*state, &H, &g);
  double lambda = 0.01;
  int iteration = 0;
  for (; iteration < options.max_iterations && cost.visible > 0; ++iteration) {
    Matrix8d damped = H;
    damped.diagonal() *= 1 + lambda;
    damped.diagonal().array() += 1e-9;
    Vector8d rhs = -g;
    if (!options.affine_brightness) {
      damped.rightCols<2>().setZero();
      damped.bottomRows<2>().setZero();
      damped.bottomRightCorner<2, 2>().setIdentity();
      rhs.tail<2>().setZero();
    }
    const Vector8d step = damped.ldlt().solve(rhs);
    if (!step.allFinite()) break;
    const AlignmentState candidate = Updated(*state, step);
    const LevelCost candidate_cost = problem.Evaluate(candidate, nullptr, nullptr);
    // A step that throws points out of the image is no improvement.
    const bool better =
        candidate_cost.PerSample() < cost.PerSample() && candidate_cost.visible > cost.visible / 2;
    if (better) {
      const double gain = 1 - candidate_cost.PerSample() / cost.PerSample();
      *state = candidate;
      lambda = std::max(lambda * 0.25, 1e-6);
      cost = problem.Evaluate(*state, &H, &g);
      if (gain < 1e-4) break;
    } else {
      if (lambda > 1e3) break;
      lambda = std::max(lambda * 8, 1e-3);
    }
  }
  return iteration;
}

LevelProblem MakeLevelProblem(const TrackingReference& reference,
                              const ImagePyramid& target,
                              int level,
                              const NoiseModel& noise,
                              const AlignmentOptions& options,
                              double widening = 1) {
  return LevelProblem(reference.levels[level],
                      reference.cameras[level],
                      target[level],
                      options,
                      options.huber * noise.FitSigma(),
                      widening * options.outlier * noise.FitSigma());
}

int AlignOnLevel(const TrackingReference& reference,
                 const ImagePyramid& target,
                 int level,
                 const NoiseModel& noise,
                 const AlignmentOptions& options,
                 AlignmentState* state) {
  // Far from the solution most residuals are large: widen the threshold until most count.
  double widening = 1;
  for (int doubling = 0; doubling < 4; ++doubling) {
    const LevelCost cost = MakeLevelProblem(reference, target, level, noise, options, widening)
                               .Evaluate(*state, nullptr, nullptr);
    if (cost.inliers > 0.6 * cost.visible) break;
    widening *= 2;
  }
  return AlignLevel(
      MakeLevelProblem(reference, target, level, noise, options, widening), options, state);
}

int NumLevels(const TrackingReference& reference, const ImagePyramid& target) {
  return static_cast<int>(std::min(target.size(), reference.levels.size()));
}

// Projects the sample's point moved by a motion; false at or inside the focal length.
bool ProjectSample(const TrackingReference::Sample& sample,
                   const PlenopticProjection& camera,
                   const RigidMotion& motion,
                   Eigen::Vector2d* px) {
  const double k = 1 - sample.rho * camera.f;
  const Eigen::Vector3d ray(sample.pixel.m.x() * k, sample.pixel.m.y() * k, 1);
  ScaledProjection::Pixel pixel;
  if (!ScaledProjection(camera).Project(
          motion.R * ray + sample.rho * motion.t, sample.rho, &pixel)) {
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
    Eigen::Vector2d start, moved, shifted;
    if (!ProjectSample(sample, camera, RigidMotion(), &start) ||
        !ProjectSample(sample, camera, motion, &moved) ||
        !ProjectSample(sample, camera, translation, &shifted)) {
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
  if (max_iterations >= 1 && huber > 0 && outlier > huber) return possible.IsValid(error);
  *error =
      "alignment needs an iteration or more and a positive Huber threshold below the outlier "
      "threshold";
  return false;
}

TrackingReference MakeTrackingReference(const PlenopticCamera& camera,
                                        const ImagePyramid& image,
                                        const std::vector<ReferencePoint>& points) {
  TrackingReference reference;
  constexpr double c2 = kGradientConstant * kGradientConstant;
  for (size_t level = 0; level < image.size(); ++level) {
    const PlenopticProjection projection(camera, static_cast<int>(level));
    std::vector<TrackingReference::Sample> samples;
    const double scale = std::ldexp(1.0, -static_cast<int>(level));
    for (const ReferencePoint& point : points) {
      const Eigen::Vector2d center = (point.px.array() + 0.5) * scale - 0.5;
      // A pattern this small is taken to have one depth.
      for (int k = 0; k < kPatternSize; ++k) {
        const bool is_center = kPattern[k][0] == 0 && kPattern[k][1] == 0;
        if (level > 0 && !is_center) continue;
        const Eigen::Vector2d px = center + Eigen::Vector2d(kPattern[k][0], kPattern[k][1]);
        if (!image[level].view().Contains(px.x(), px.y(), 1)) continue;
        const InterpolatedValue value = InterpolateBilinear(image[level], px.x(), px.y());
        const Eigen::Vector2d m = (px - projection.c) * (projection.s / projection.f);
        const double gradient2 = value.dx * value.dx + value.dy * value.dy;
        samples.push_back({{m, value.value, c2 / (c2 + gradient2)}, point.rho});
      }
    }
    reference.cameras.push_back(projection);
    reference.levels.push_back(std::move(samples));
  }
  return reference;
}

std::vector<AlignmentState> RankStarts(const TrackingReference& reference,
                                       const ImagePyramid& target,
                                       const std::vector<AlignmentState>& starts,
                                       const NoiseModel& noise,
                                       const AlignmentOptions& options) {
  const int num_levels = NumLevels(reference, target);
  if (num_levels == 0 || reference.empty()) return {};
  const int level = num_levels - 1;
  const LevelProblem problem = MakeLevelProblem(reference, target, level, noise, options);
  const double num_samples = static_cast<double>(reference.levels[level].size());
  using Fit = std::pair<double, AlignmentState>;  // with its cost
  const auto align_all = [&](int max_iterations, std::vector<Fit>* fits) {
    AlignmentOptions few = options;
    few.max_iterations = std::min(max_iterations, options.max_iterations);
    for (auto& [cost, state] : *fits) {
      AlignOnLevel(reference, target, level, noise, few, &state);
      const LevelCost reached = problem.Evaluate(state, nullptr, nullptr);
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
  align_all(options.max_iterations, &fits);
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
    Eigen::Vector2d px_left, px_right;
    if (ProjectSample(sample, camera, motion_left, &px_left) &&
        ProjectSample(sample, camera, motion_right, &px_right)) {
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
  for (int level = num_levels - 1; level >= 0; --level) {
    result.iterations += AlignOnLevel(reference, target, level, noise, options, &result.state);
    if (level > 0) continue;
    const LevelCost cost = MakeLevelProblem(reference, target, 0, noise, options)
                               .Evaluate(result.state, nullptr, nullptr);
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
