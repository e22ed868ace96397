// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/recovery.h"

#include <utility>

#include "prism/factors/depth_offset_term.h"
#include "prism/tracking/depth_agreement.h"
#include "prism/tracking/reference_points.h"

namespace prism {
RecoveryResult Recover(const FitLimits& limits,
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
    result.tracking =
        trial.Track(frame.image,
                    frame.time_ns,
                    window.noise,
                    MakeDepthCheck(window.noise, frame, PersistentDepthOffset(window.newest()), 0));
    if (result.tracking.status == TrackingStatus::kNoTexture) return result;
    if (result.tracking.status != TrackingStatus::kGood) continue;
    if (limits.AreMetBy(result.tracking.alignment.fit)) {
      *tracker = std::move(trial);
      result.reference = &keyframe;
      return result;
    }
    result.tracking.status = TrackingStatus::kLost;
  }
  return result;
}

}  // namespace prism
