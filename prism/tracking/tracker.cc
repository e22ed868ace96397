// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "prism/base/statistics.h"
#include "prism/image/noise.h"

namespace prism {
namespace {

double RmsGradient(const ImageViewF& image) {
  const ImageF squared = SquaredGradientMagnitude(image);
  double sum = 0;
  for (size_t i = 0; i < squared.size(); ++i) sum += squared.data()[i];
  return std::sqrt(sum / static_cast<double>(squared.size()));
}

// Quantiles of an image's intensities, evenly spaced.
std::vector<double> Intensities(const ImagePyramid& image) {
  constexpr int kCount = 20;
  const ImageF& coarse = image[std::min<size_t>(3, image.size() - 1)];
  std::vector<double> values(coarse.data(), coarse.data() + coarse.size());
  std::sort(values.begin(), values.end());
  std::vector<double> quantiles;
  for (int i = 1; i < kCount; ++i) quantiles.push_back(values[values.size() * i / kCount]);
  return quantiles;
}

// By what the exposure has changed between two frames of much the same view; 1 if nothing tells.
double ExposureRatio(const std::vector<double>& before, const std::vector<double>& now) {
  constexpr double kDark = 5, kBright = 250;
  std::vector<double> ratios;
  for (size_t i = 0; i < before.size(); ++i) {
    if (std::min(before[i], now[i]) > kDark && std::max(before[i], now[i]) < kBright) {
      ratios.push_back(now[i] / before[i]);
    }
  }
  return ratios.empty() ? 1 : Quantile(ratios, 0.5);
}

// The level on which texture is judged: noise counts less there.
const ImageF& TextureLevel(const ImagePyramid& image) {
  return image[std::min<size_t>(1, image.size() - 1)];
}

// The square of a pattern-free image's gradient is that of its noise: it shows nothing.
bool ShowsNothing(const ImageF& image, double gradient, double min_rms_gradient) {
  constexpr double kMinOverNoise = 1.3;
  if (gradient < min_rms_gradient) return true;
  constexpr double kSurelyTexture = 4;  // 0 to 255 a px
  return gradient < kSurelyTexture && gradient < kMinOverNoise * EstimateImageNoise(image);
}

// By how much more constant velocity is off after `steps` times the time between the two frames it
// is known from, against one: acceleration is what it leaves out.
double ErrorGrowth(double steps) { return steps * (steps + 1) / 2; }

PoseSigma SigmaOf(const Matrix6d& information) {
  const Matrix6d covariance =
      (information + 1e-6 * Matrix6d::Identity()).ldlt().solve(Matrix6d::Identity());
  return {std::sqrt(covariance.diagonal().head<3>().mean()),
          std::sqrt(covariance.diagonal().tail<3>().mean())};
}

Matrix6d InformationOf(const PoseSigma& sigma) {
  Vector6d inverse_variance;
  inverse_variance.head<3>().setConstant(1 / (sigma.translation_m * sigma.translation_m));
  inverse_variance.tail<3>().setConstant(1 / (sigma.rotation_rad * sigma.rotation_rad));
  return inverse_variance.asDiagonal();
}

}  // namespace

bool TrackerOptions::IsValid(std::string* error) const {
  if (!alignment.IsValid(error) || !fit.IsValid(error)) return false;
  if (min_rms_gradient >= 0 && retry_steps >= 0 && retry_step > 0 && max_retries >= 1 &&
      exclude_after >= 1 && min_held_points >= 6 && max_held_distance > 0 && max_held_steps > 0 &&
      max_held_gradient > 0 && min_held_fraction >= 0) {
    return true;
  }
  *error =
      "tracking needs a gradient and retry steps of 0 or more, a positive retry step, a retry and "
      "a "
      "misfit or more, and 6 points or more near a prediction to hold a frame there";
  return false;
}

void Tracker::SetReference(TrackingReference reference, const SE3& new_from_old_reference) {
  const SE3 old_from_new = new_from_old_reference.Inverse();
  for (TrackedFrame& frame : history_) {
    frame.state.target_from_reference = frame.state.target_from_reference * old_from_new;
  }
  // Brightness is relative to the reference too: the newest frame is (or is close to) the new one.
  const AlignmentState newest = history_.back().state;
  for (TrackedFrame& frame : history_) {
    frame.state.a -= newest.a;
    frame.state.b -= std::exp(frame.state.a) * newest.b;
  }
  reference_ = std::move(reference);
  misfits_.assign(reference_.points.size(), 0);
}

void Tracker::Start(TrackingReference reference, const ImagePyramid& image, int64_t time_ns) {
  reference_ = std::move(reference);
  misfits_.assign(reference_.points.size(), 0);
  history_ = {{time_ns, AlignmentState()}};
  motion_errors_.clear();
  last_intensities_ = Intensities(image);
}

double Tracker::StepsTo(int64_t time_ns) const {
  if (!KnowsMotion()) return 0;
  const double known_ns = static_cast<double>(history_[1].time_ns - history_[0].time_ns);
  const double wanted_ns = static_cast<double>(time_ns - history_[1].time_ns);
  return known_ns > 0 && wanted_ns > 0 ? wanted_ns / known_ns : 0;
}

SE3 Tracker::Motion(int64_t time_ns, double fraction) const {
  const double steps = StepsTo(time_ns);
  if (steps == 0) return SE3();
  const SE3 motion =
      history_[1].state.target_from_reference * history_[0].state.target_from_reference.Inverse();
  return SE3::Exp(fraction * steps * motion.Log());
}

AlignmentState Tracker::Prediction(int64_t time_ns) const {
  AlignmentState state = history_.back().state;
  state.target_from_reference = Motion(time_ns, 1) * state.target_from_reference;
  return state;
}

AlignmentState Tracker::WithBrightness(const ImagePyramid& target,
                                       const std::vector<double>& intensities,
                                       const NoiseModel& noise,
                                       const AlignmentState& prediction) const {
  if (reference_.empty()) return prediction;
  const double ratio = ExposureRatio(last_intensities_, intensities);
  AlignmentState changed = prediction;
  changed.a += std::log(ratio);
  changed.b *= ratio;
  const int level = static_cast<int>(std::min(target.size(), reference_.levels.size())) - 1;
  const LevelAlignment problem(reference_, target[level], level, noise, options_.alignment.level);
  return problem.Evaluate(changed).PerSample() < problem.Evaluate(prediction).PerSample()
             ? changed
             : prediction;
}

std::vector<AlignmentState> Tracker::OtherStarts(int64_t time_ns,
                                                 const AlignmentState& prediction) const {
  std::vector<AlignmentState> starts;
  const SE3& last = history_.back().state.target_from_reference;
  const auto start_at = [&](const SE3& target_from_reference) {
    starts.push_back(prediction);  // with its brightness
    starts.back().target_from_reference = target_from_reference;
  };
  start_at(prediction.target_from_reference);
  if (KnowsMotion()) {
    for (const double fraction : {0.5, 0.0, 2.0}) start_at(Motion(time_ns, fraction) * last);
  }
  start_at(SE3());  // back at the keyframe
  if (reference_.cameras.empty()) return starts;

  const PlenopticProjection& coarsest = reference_.cameras.back();
  const auto turn = [&](double x, double y, double z) {
    start_at(SE3::Exp((Vector6d() << 0, 0, 0, x, y, z).finished()) *
             prediction.target_from_reference);
  };
  const double step = options_.retry_step / coarsest.FocalLengthPx();
  for (int y = -options_.retry_steps; y <= options_.retry_steps; ++y) {
    for (int x = -options_.retry_steps; x <= options_.retry_steps; ++x) {
      if (x != 0 || y != 0) turn(step * x, step * y, 0);
    }
  }
  const double roll = 2 * options_.retry_step / coarsest.width;
  turn(0, 0, roll);
  turn(0, 0, -roll);
  return starts;
}

TrackingResult Tracker::Track(const ImagePyramid& target,
                              int64_t time_ns,
                              const NoiseModel& noise,
                              const DepthCheck& check_depth) {
  TrackingResult result;
  const double gradient = RmsGradient(TextureLevel(target));
  if (ShowsNothing(TextureLevel(target), gradient, options_.min_rms_gradient)) {
    result.status = TrackingStatus::kNoTexture;
    return result;
  }
  std::vector<double> intensities = Intensities(target);
  const AlignmentState prediction = WithBrightness(target, intensities, noise, Prediction(time_ns));
  // Images of a real camera may be misplaced by a share of a pixel here and there, and then scatter
  // by more than their noise: the first frames show by how much.
  for (const double wider : {1.0, 1.6, 2.5}) {
    const NoiseModel assumed = noise.WithWiderFit(wider);
    result = TryStarts(target, time_ns, prediction, assumed);
    Judge(assumed, check_depth, &result);
    if (result.status == TrackingStatus::kGood || noise.KnowsFit()) break;
  }
  if (result.status != TrackingStatus::kGood) return result;
  result.sigma =
      SigmaOf(PoseInformation(reference_, target, result.alignment, noise, options_.alignment));
  ExcludePoints(result.alignment.points.fits);
  ObserveMotion(time_ns, result.alignment.state.target_from_reference);
  constexpr size_t kMaxGradients = 20;
  gradients_.push_back(gradient);
  if (gradients_.size() > kMaxGradients) gradients_.erase(gradients_.begin());
  Remember(time_ns, result.alignment.state, std::move(intensities));
  return result;
}

void Tracker::Remember(int64_t time_ns,
                       const AlignmentState& state,
                       std::vector<double> intensities) {
  last_intensities_ = std::move(intensities);
  history_.push_back({time_ns, state});
  if (history_.size() > 2) history_.erase(history_.begin());
}

std::optional<MotionPrediction> Tracker::PredictMotion(int64_t time_ns) const {
  constexpr size_t kMinErrors = 4;
  constexpr double kMaxSteps = 15;  // later, hands and robots have turned elsewhere
  if (!KnowsMotion() || motion_errors_.size() < kMinErrors || StepsTo(time_ns) > kMaxSteps) {
    return std::nullopt;
  }
  std::vector<double> translations, rotations;
  for (const PoseSigma& error : motion_errors_) {
    translations.push_back(error.translation_m);
    rotations.push_back(error.rotation_rad);
  }
  // Errors are lengths of three axes; their median is 1.54 standard deviations of one.
  const double growth = ErrorGrowth(StepsTo(time_ns)) / 1.54;
  constexpr double kMinTranslation_m = 1e-4, kMinRotation_rad = 1e-4;
  return MotionPrediction{Prediction(time_ns).target_from_reference,
                          {std::max(growth * Quantile(translations, 0.5), kMinTranslation_m),
                           std::max(growth * Quantile(rotations, 0.5), kMinRotation_rad)}};
}

double MotionPrediction::DistanceTo(const SE3& other_target_from_reference) const {
  const Vector6d step = (other_target_from_reference * target_from_reference.Inverse()).Log();
  return std::sqrt(step.dot(InformationOf(sigma) * step));
}

void Tracker::ObserveMotion(int64_t time_ns, const SE3& target_from_reference) {
  constexpr size_t kMaxErrors = 20;
  const double steps = StepsTo(time_ns);
  if (!(steps > 0)) return;
  const SE3 error = target_from_reference * Prediction(time_ns).target_from_reference.Inverse();
  const double growth = ErrorGrowth(steps);
  motion_errors_.push_back({error.translation().norm() / growth, RotationAngle(error) / growth});
  if (motion_errors_.size() > kMaxErrors) motion_errors_.erase(motion_errors_.begin());
}

TrackingResult Tracker::Hold(const ImagePyramid& target,
                             int64_t time_ns,
                             const NoiseModel& noise,
                             const DepthCheck& check_depth) {
  TrackingResult result;
  const std::optional<MotionPrediction> motion = PredictMotion(time_ns);
  // A rich view that does not match is somewhere else.
  if (!motion || StepsTo(time_ns) > options_.max_held_steps ||
      RmsGradient(TextureLevel(target)) > options_.max_held_gradient * Quantile(gradients_, 0.5)) {
    return result;
  }
  // A blank view would be explained by a gain of 0.
  AlignmentOptions options = options_.alignment;
  options.level.affine_brightness = false;
  const PosePrior prior = {motion->target_from_reference, InformationOf(motion->sigma)};
  constexpr int kNear = 2;
  FrameAlignmentResult& held = result.alignment;
  held = AlignFrame(reference_, target, Prediction(time_ns), noise, options, kNear, &prior);
  result.attempts = 1;
  const int fitting = held.points.seen - held.points.outliers;
  if (fitting < options_.min_held_points ||
      fitting < options_.min_held_fraction * static_cast<double>(reference_.points.size()) ||
      motion->DistanceTo(held.state.target_from_reference) > options_.max_held_distance) {
    return result;
  }
  if (check_depth) held.fit.depth_agreement = check_depth(reference_, held);
  if (!options_.fit.held.AreMetBy(held.fit)) return result;
  result.status = TrackingStatus::kHeld;
  result.sigma = SigmaOf(PoseInformation(reference_, target, held, noise, options, &prior));
  Remember(time_ns, held.state, Intensities(target));
  return result;
}

void Tracker::ExcludePoints(const std::vector<PointFit>& fits) {
  for (size_t i = 0; i < fits.size(); ++i) {
    if (fits[i] == PointFit::kUnseen) continue;
    misfits_[i] = fits[i] == PointFit::kOutlier ? misfits_[i] + 1 : 0;
    reference_.points[i].is_excluded = misfits_[i] >= options_.exclude_after;
  }
}

TrackingResult Tracker::TryStarts(const ImagePyramid& target,
                                  int64_t time_ns,
                                  const AlignmentState& prediction,
                                  const NoiseModel& noise) const {
  const auto align = [&](const AlignmentState& start, int coarsest_level = kAllLevels) {
    return AlignFrame(reference_, target, start, noise, options_.alignment, coarsest_level);
  };
  const auto is_good = [&](const FrameAlignmentResult& alignment) {
    return alignment.status == AlignmentStatus::kGood && options_.fit.good.AreMetBy(alignment.fit);
  };
  // Takes a fit that costs less than `max_cost`, or any if there is none yet.
  TrackingResult result;
  const auto take_if_better = [&](const FrameAlignmentResult& alignment, double max_cost) {
    ++result.attempts;
    const bool is_better =
        alignment.status == AlignmentStatus::kGood &&
        (result.alignment.status != AlignmentStatus::kGood || alignment.cost < max_cost);
    if (is_better) result.alignment = alignment;
    return is_better;
  };
  result.alignment = align(prediction);
  result.attempts = 1;
  const auto is_far = [&](const FrameAlignmentResult& alignment) {
    constexpr double kFar = 5;  // px of level 0
    return KnowsMotion() && FlowBetween(reference_,
                                        prediction.target_from_reference,
                                        alignment.state.target_from_reference) > kFar;
  };
  if (!is_good(result.alignment) || is_far(result.alignment)) {
    // On the coarsest levels, what hides a part of the view drags the rest along. Where motion is
    // steady the prediction is near enough for the finer ones.
    constexpr int kNear = 2;
    take_if_better(align(prediction, kNear), result.alignment.cost);
  }
  // A good fit is the right one where motion predicts it. Without a prediction it may be another
  // minimum: along two parallel edges there are several, and near each other.
  const auto is_settled = [&] { return KnowsMotion() && is_good(result.alignment); };
  if (is_settled()) return result;

  // Near its start a frame is rather half hidden than somewhere else.
  double max_cost = options_.max_cost_ratio * result.alignment.cost;
  const SE3 first = result.alignment.state.target_from_reference;
  int retries = 0;
  for (const AlignmentState& start : RankStarts(
           reference_, target, OtherStarts(time_ns, prediction), noise, options_.alignment)) {
    if (KnowsMotion() && AreOneMinimum(reference_, start.target_from_reference, first)) continue;
    if (take_if_better(align(start), max_cost)) max_cost = result.alignment.cost;
    if (is_settled() || ++retries == options_.max_retries) break;
  }
  return result;
}

void Tracker::Judge(const NoiseModel& noise,
                    const DepthCheck& check_depth,
                    TrackingResult* result) const {
  FrameAlignmentResult& alignment = result->alignment;
  if (alignment.status != AlignmentStatus::kGood) return;
  const FitLimits& limits = noise.KnowsFit() ? options_.fit.match : options_.fit.start;
  if (!limits.AreMetBy(alignment.fit)) return;  // of images alone, so far
  if (check_depth) alignment.fit.depth_agreement = check_depth(reference_, alignment);
  result->status =
      limits.AreMetBy(alignment.fit) ? TrackingStatus::kGood : TrackingStatus::kDepthsDisagree;
}

}  // namespace prism
