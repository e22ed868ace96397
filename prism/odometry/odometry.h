// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/scene/frame.h"
#include "prism/scene/trajectory.h"
#include "prism/tracking/keyframe_decision.h"
#include "prism/tracking/point_selection.h"
#include "prism/tracking/tracker.h"
#include "prism/window/activation.h"
#include "prism/window/candidates.h"
#include "prism/window/marginalization.h"
#include "prism/window/optimize.h"
#include "prism/window/outliers.h"
#include "prism/window/window.h"

namespace prism {

// What a match after a loss must show beyond that of an ordinary frame: nothing but the images
// speaks for it, and a wrong pose spoils the map.
struct RecoveryOptions {
  double max_rms_ratio = 1.5;         // RMS over the median of the frames tracked before
  double max_outlier_fraction = 0.2;  // of the samples
  double min_visible_fraction = 0.5;  // of the samples
  double max_log_gain = 0.3;          // |a - a of the keyframe|
  double min_depth_agreement = 0.8;   // see DepthAgreement
};

struct OdometryOptions {
  PointSelectionOptions selection;
  TrackerOptions tracker;
  KeyframeOptions keyframe;
  WindowOptions window;
  RefinementOptions refinement;
  CandidateOptions candidates;
  OutlierOptions outliers;
  RetirementOptions retirement;
  // Standard deviation of what makes photometric residuals beside noise (interpolation, depth
  // edges, reflections), 0 to 255. With the noise measured in the first image n, residuals are
  // weighted by sqrt(2 n^2 + this^2).
  double photometric_model_sigma = 3.5;
  int max_new_points = 600;    // activated per keyframe
  int min_point_distance = 4;  // px between active points in the newest keyframe
  int min_start_points = 100;  // with depth, to start a segment
  int max_lost_frames = 5;     // in a row, then a new segment is started

  RecoveryOptions recovery;

  bool IsValid(std::string* error) const;
};

enum class FrameStatus { kTracked, kNoTexture, kLost };
const char* ToString(FrameStatus status);

struct FrameResult {
  int64_t time_ns = 0;
  FrameStatus status = FrameStatus::kLost;
  int segment = 0;
  bool is_keyframe = false;
  int keyframe_id = -1;             // its own, or the one it was tracked on
  FrameState state;                 // cam_from_world at this moment, absolute brightness
  double rms = 0;                   // of the alignment, intensities
  int points_used = 0;              // inlier samples of the alignment
  int active_points = 0;            // in the window
  OptimizationResult optimization;  // of a keyframe
};

// A scene point in metres with its intensity (0 to 255).
struct MapPoint {
  Eigen::Vector3d p_in_world = Eigen::Vector3d::Zero();
  float intensity = 0;
};

// Metric visual odometry from plenoptic frames. The first frame is a keyframe whose points take
// their depth from the measured virtual depth; world is the camera frame of the first frame.
//
// A frame that cannot be tracked has a status and no pose. The frames after it are tried against
// the keyframes of the window; after `max_lost_frames` in a row a new segment starts at the next
// frame with texture and depth, metric like the first, placed at the last known pose.
class Odometry {
 public:
  Odometry(const PlenopticCamera& camera, const OdometryOptions& options);

  FrameResult Process(LightFieldFrame frame);

  // All tracked frames, each carried by the final pose of the keyframe it was tracked on.
  Trajectory FrameTrajectory() const;
  Trajectory KeyframeTrajectory() const;
  // Points that left the window and those in it, by the final poses of their keyframes.
  std::vector<MapPoint> MapPoints() const;

  // Standard deviation photometric residuals are weighted by; 0 before the first frame.
  double intensity_sigma() const { return options_.window.photometric.intensity_sigma; }
  const Window& window() const { return window_; }
  const StageTimer& timer() const { return timer_; }

 private:
  struct TrackedFrame {
    int64_t time_ns;
    int keyframe_id;
    SE3 cam_from_keyframe;
  };

  using FramePtr = std::shared_ptr<const LightFieldFrame>;

  // Tracks against the newest keyframe, after a loss against all; the keyframe that worked, or
  // null.
  const Keyframe* Track(const LightFieldFrame& frame, TrackingResult* tracking);
  bool IsCredible(const LightFieldFrame& frame,
                  const Keyframe& keyframe,
                  const FrameAlignmentResult& alignment) const;
  FrameResult StartSegment(FramePtr frame);
  FrameResult HandleLoss(FramePtr frame, TrackingStatus status);
  void MakeKeyframe(FramePtr frame, const SE3& reference_pose, FrameResult* result);
  void ActivatePoints();
  void RetireKeyframes();
  TrackingReference MakeReference(const Keyframe& reference) const;
  void RememberKeyframePoses();

  PlenopticCamera camera_;
  OdometryOptions options_;
  StageTimer timer_;
  Window window_;
  Tracker tracker_;
  int next_keyframe_id_ = 0;
  int segment_ = 0;
  int lost_frames_ = 0;   // in a row
  SE3 last_pose_;         // cam_from_world of the last tracked frame
  double first_rms_ = 0;  // of the first frame tracked on the newest keyframe
  std::vector<TrackedFrame> tracked_frames_;
  struct KeyframePose {
    int64_t time_ns = 0;
    SE3 cam_from_world;
  };
  std::map<int, KeyframePose> keyframe_poses_;
  std::vector<RetiredPoint> retired_points_;
};

}  // namespace prism
