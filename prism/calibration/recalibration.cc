// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/recalibration.h"

#include <cmath>

#include <glog/logging.h>

#include "prism/base/format.h"
#include "prism/odometry/odometry.h"

namespace prism {
namespace {

// A camera does not change from keyframe to keyframe.
constexpr double kStepSigma = 1e-6;  // of 1/v
// Of 1/v: errors of measured depth that go with distance pass for an error of b_L0 (docs/depth.md).
constexpr double kSystematic = 0.0006;
constexpr double kFewestTracked = 0.5;  // of the frames
constexpr int kFewestKeyframes = 2;     // below, a window states no uncertainty
constexpr double kTold = 0.5;           // of the prior's standard deviation

// Sums over points of w^2, weighted as their measurements are.
struct SquaredDepths {
  double sum = 0, weights = 0;

  void Add(const Window& window) {
    if (window.keyframes.empty()) return;
    for (const auto& point : window.keyframes.back()->points) {
      if (!(point->w_sigma > 0)) continue;
      const double weight = 1 / (point->w_sigma * point->w_sigma);
      sum += weight * point->w_measured * point->w_measured;
      weights += weight;
    }
  }
  double Mean() const { return sum / weights; }
};

struct Offset {
  double value = 0, sigma = 0;  // of 1/v
};

// What was missing in a pass that tells nothing of the offset; empty: nothing.
std::string WhyNothingIsKnown(const RecalibrationPass& pass,
                              int frames,
                              int tracked,
                              int keyframes,
                              const std::optional<Offset>& offset,
                              double depth_weights) {
  if (frames == 0) return "no frames";
  if (pass.tracked < kFewestTracked) {
    return Format("%d of %d frames could be tracked", tracked, frames);
  }
  const std::string of_frames = Format("%d of %d frames were tracked, but ", tracked, frames);
  if (keyframes < kFewestKeyframes) {
    return of_frames + Format("they make %d keyframe%s, and it takes %d: the camera has to move",
                              keyframes,
                              keyframes == 1 ? "" : "s",
                              kFewestKeyframes);
  }
  if (!offset) {
    return of_frames +
           Format(
               "in none of %d keyframes was it determined how far their depths are off: more "
               "motion in other directions, or more texture, would tell it",
               keyframes);
  }
  if (depth_weights == 0) {
    return of_frames +
           "no measured depth fits what the images tell: the camera is off by more than a turn of "
           "the focus ring";
  }
  return "";
}

}  // namespace

bool RecalibrationOptions::IsValid(std::string* error) const {
  if (!odometry.IsValid(error)) return false;
  if (prior_sigma > 0 && max_passes > 0 && converged > 0) return true;
  *error = "a recalibration needs a positive prior deviation, passes and threshold";
  return false;
}

RecalibrationResult Recalibrate(const PlenopticCamera& camera,
                                const RecalibrationOptions& options,
                                const std::function<FrameStream()>& open) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  OdometryOptions odometry_options = options.odometry;
  odometry_options.default_terms.depth_offset.prior_sigma = options.prior_sigma;
  odometry_options.default_terms.depth_offset.step_sigma = kStepSigma;

  RecalibrationResult result;
  result.camera = camera;
  for (int i = 0; i < options.max_passes; ++i) {
    Odometry odometry(result.camera, odometry_options);
    SquaredDepths depths;
    std::optional<Offset> offset;
    int frames = 0, tracked = 0, keyframes = 0;
    RecalibrationPass pass;
    const FrameStream next = open();
    while (std::optional<LightFieldFrame> frame = next()) {
      const FrameResult found = odometry.Process(std::move(*frame));
      ++frames;
      tracked += HasPose(found.status);
      pass.segments = found.segment + 1;
      keyframes += found.is_keyframe;
      if (const auto& known = found.keyframe.optimization.uncertainty) {
        offset = {known->depth_offset, known->depth_offset_sigma};
        depths.Add(odometry.window());
      }
    }
    pass.tracked = frames > 0 ? static_cast<double>(tracked) / frames : 0;
    result.passes.push_back(pass);
    result.problem = WhyNothingIsKnown(pass, frames, tracked, keyframes, offset, depths.weights);
    if (!result.problem.empty()) return result;
    // dw / db_L0 = w^2 / B, in either mode with B > 0 and its sign.
    const double per_offset =
        camera.virtual_depth_sign() * camera.sensor_mla_distance / depths.Mean();
    pass.moved_m = per_offset * offset->value;
    pass.sigma_m = std::abs(per_offset) * std::hypot(offset->sigma, kSystematic);
    result.passes.back() = pass;
    result.sigma_m = pass.sigma_m;
    if (offset->sigma > kTold * options.prior_sigma) {
      result.problem =
          Format("the scene tells b_L0 to %.1f um only: near and far things in one view would",
                 1e6 * pass.sigma_m);
      return result;
    }
    result.moved_m += pass.moved_m;
    result.camera.main_lens_mla_distance += pass.moved_m;
    if (!result.camera.HasMetricDepth(&error)) {
      result.problem = "the camera found makes no sense: " + error;
      return result;
    }
    if (std::abs(pass.moved_m) < options.converged * pass.sigma_m) return result;
  }
  return result;
}

}  // namespace prism
