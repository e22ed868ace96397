// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/recovery.h"

#include <cmath>
#include <utility>

#include "prism/tracking/depth_agreement.h"
#include "prism/tracking/reference_points.h"

namespace prism {
namespace {

bool IsCredible(const RecoveryOptions& options,
                const Window& window,
                const LightFieldFrame& frame,
                const Keyframe& keyframe,
                const Tracker& tracker,
                const FrameAlignmentResult& alignment) {
  const SE3 pose = alignment.state.target_from_reference * keyframe.state.pose();
  return (!tracker.KnowsFit() || alignment.rms <= options.max_rms_ratio * tracker.TypicalRms()) &&
         alignment.outlier_fraction <= options.max_outlier_fraction &&
         alignment.visible_fraction >= options.min_visible_fraction &&
         std::abs(alignment.state.a) <= options.max_log_gain &&
         DepthAgreement(window, frame, pose) >= options.min_depth_agreement;
}

}  // namespace

bool RecoveryOptions::IsValid(std::string* error) const {
  if (max_rms_ratio > 0 && max_outlier_fraction > 0 && min_visible_fraction >= 0 &&
      max_log_gain > 0 && min_depth_agreement >= 0 && min_depth_agreement <= 1) {
    return true;
  }
  *error = "recovery needs positive limits and fractions in [0, 1]";
  return false;
}

RecoveryResult Recover(const RecoveryOptions& options,
                       const PlenopticCamera& camera,
                       const Window& window,
                       const LightFieldFrame& frame,
                       Tracker* tracker) {
  RecoveryResult result;
  for (size_t i = window.keyframes.size(); i-- > 0;) {
    const Keyframe& keyframe = *window.keyframes[i];
    Tracker trial = *tracker;
    trial.SetReference(
        MakeTrackingReference(camera, keyframe.frame->image, MakeReferencePoints(window, keyframe)),
        keyframe.state.pose() * window.newest().state.pose().Inverse());
    result.tracking = trial.Track(frame.image);
    if (result.tracking.status == TrackingStatus::kNoTexture) return result;
    if (result.tracking.status != TrackingStatus::kGood) continue;
    if (IsCredible(options, window, frame, keyframe, *tracker, result.tracking.alignment)) {
      *tracker = std::move(trial);
      result.reference = &keyframe;
      return result;
    }
    result.tracking.status = TrackingStatus::kLost;
  }
  return result;
}

}  // namespace prism
