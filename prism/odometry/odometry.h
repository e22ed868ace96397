// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/odometry/map.h"
#include "prism/odometry/options.h"
#include "prism/odometry/recent_frames.h"
#include "prism/points/outliers.h"
#include "prism/scene/frame.h"
#include "prism/window/optimize.h"

namespace prism {

enum class FrameStatus {
  kTracked,
  kNoTexture,
  kLost,
  kDepthsDisagree,  // the images match, but not the depths the frame measures itself: lost as well
};
const char* ToString(FrameStatus status);

enum class KeyframeStatus {
  kGood,
  kPoorFit,    // residuals or outliers of a term beyond FitOptions::match
  kNotSolved,  // the solver found nothing usable: the window stayed as it was
};
const char* ToString(KeyframeStatus status);

// What became of a keyframe's window.
struct KeyframeResult {
  KeyframeStatus status = KeyframeStatus::kGood;
  OptimizationResult optimization;
  OutlierResult outliers;
};

struct FrameResult {
  int64_t time_ns = 0;
  FrameStatus status = FrameStatus::kLost;
  int segment = 0;
  bool is_keyframe = false;
  int keyframe_id = -1;   // its own, or the one it was tracked on
  FrameState state;       // cam_from_world at this moment, absolute brightness
  FitQuality fit;         // of the alignment
  double rms = 0;         // of the alignment, intensities
  int points_used = 0;    // of the reference, that fit
  int active_points = 0;  // in the window
  // Of keyframes whose window was optimised: all but the first of a segment.
  KeyframeResult keyframe;
};

// Metric visual odometry from plenoptic frames. The first frame is a keyframe whose points take
// their depth from the measured virtual depth; world is the camera frame of the first frame.
//
// A frame that cannot be tracked has a status and no pose. The frames after it are tried against
// the keyframes of the window; after `max_lost_frames` in a row a new segment starts at the next
// frame with texture and depth, metric like the first, placed at the last known pose.
class Odometry {
 public:
  // Precondition: options.IsValid.
  Odometry(const PlenopticCamera& camera, const OdometryOptions& options);

  FrameResult Process(LightFieldFrame frame);

  Trajectory FrameTrajectory() const { return map_.FrameTrajectory(); }
  Trajectory KeyframeTrajectory() const { return map_.KeyframeTrajectory(); }
  std::vector<MapPoint> MapPoints() const { return map_.Points(window_); }

  const Window& window() const { return window_; }
  // All terms of the cost, the default ones first.
  const TermList& terms() const { return terms_; }
  const StageTimer& timer() const { return timer_; }

 private:
  using FramePtr = std::shared_ptr<const LightFieldFrame>;

  FrameResult StartSegment(FramePtr frame);
  FrameResult HandleLoss(FramePtr frame, TrackingStatus status);
  void AddKeyframe(FramePtr frame, const FrameState& state);
  KeyframeResult MakeKeyframe(FramePtr frame,
                              const FrameState& state,
                              const SE3& reference_pose,
                              const PointFits& point_fits);
  TrackingReference MakeReference(const Keyframe& keyframe);

  PlenopticCamera camera_;
  OdometryOptions options_;
  TermList terms_;
  StageTimer timer_;
  Window window_;
  Tracker tracker_;
  Map map_;
  RecentFrames recent_frames_;
  int next_keyframe_id_ = 0;
  int segment_ = 0;
  int lost_frames_ = 0;   // in a row
  SE3 last_pose_;         // cam_from_world of the last tracked frame
  double first_rms_ = 0;  // of the first frame tracked on the newest keyframe
};

}  // namespace prism
