// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/map/map.h"
#include "prism/odometry/joining.h"
#include "prism/odometry/options.h"
#include "prism/odometry/recent_frames.h"
#include "prism/odometry/recovery.h"
#include "prism/points/outliers.h"
#include "prism/scene/frame.h"
#include "prism/window/optimize.h"

namespace prism {

enum class FrameStatus {
  kTracked,
  kHeld,  // tracked on little, and held by the motion before: less certain (FrameResult::sigma)
  kNoTexture,
  kLost,
  kDepthsDisagree,  // the images match, but not the depths the frame measures itself: lost as well
  kUnreadable,      // there was no frame (Odometry::Skip)
};
const char* ToString(FrameStatus status);
// kTracked or kHeld.
bool HasPose(FrameStatus status);

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

// A segment that was found to show what an earlier one does.
struct JoinedSegment {
  int segment = 0;         // with the piece of the map that it was part of
  int piece = 0;           // it is part of now
  SE3 new_world_from_old;  // of what was moved
};

struct FrameResult {
  int64_t time_ns = 0;
  FrameStatus status = FrameStatus::kLost;
  int segment = 0;
  bool is_keyframe = false;
  int keyframe_id = -1;  // its own, or the one it was tracked on
  // cam_from_world at this moment, absolute brightness. Of frames without a pose: where motion
  // alone says they are, while `sigma` is above 0.
  FrameState state;
  PoseSigma sigma;        // of the pose relative to its keyframe, as stated by residuals and motion
  FitQuality fit;         // of the alignment
  double rms = 0;         // of the alignment, intensities
  int points_used = 0;    // of the reference, that fit
  int active_points = 0;  // in the window
  // Of keyframes whose window was optimised: all but the first of a segment.
  KeyframeResult keyframe;
  std::optional<JoinedSegment> joined;  // with this keyframe
  // Its segment, joined before, was moved to where this keyframe says as well.
  bool has_settled = false;
};

// Metric visual odometry from plenoptic frames. The first frame is a keyframe whose points take
// their depth from the measured virtual depth; world is the camera frame of the first frame.
//
// A frame that cannot be tracked has a status and no pose. The frames after it are tried against
// the keyframes of the window, then against the places that have left it. Where one is found, or
// after `max_lost_frames` in a row, a new segment starts at the next frame with texture and depth,
// metric like the first, placed where it was found or at the last known pose. Its keyframes are
// looked for in the rest of the map; once enough of them agree, the segment is joined to it.
//
// Images are smoothed (Smooth) before anything else; the window and the places have them so.
class Odometry {
 public:
  // Precondition: options.IsValid.
  Odometry(const PlenopticCamera& camera, const OdometryOptions& options);

  // Places of an earlier run, in which this one may find itself. To be called before Process.
  void LoadPlaces(const std::vector<MappedPlace>& places);

  FrameResult Process(LightFieldFrame frame);

  // A frame that should have come at this time and did not. Changes nothing for the frames after
  // it; the result has the pose that motion predicts.
  FrameResult Skip(int64_t time_ns) const;

  Trajectory FrameTrajectory() const { return map_.FrameTrajectory(); }
  Trajectory KeyframeTrajectory() const { return map_.KeyframeTrajectory(); }
  std::vector<MapPoint> MapPoints() const { return map_.Points(window_); }
  const Map& map() const { return map_; }
  // The map with the keyframes of the window among its places, as a later run wants it.
  Map CompleteMap() const;

  const Window& window() const { return window_; }
  // All terms of the cost, the default ones first.
  const TermList& terms() const { return terms_; }
  const StageTimer& timer() const { return timer_; }

 private:
  using FramePtr = std::shared_ptr<const LightFieldFrame>;

  // A frame that shows a known place.
  struct Recognition {
    SE3 world_from_cam;
    std::vector<ReferencePoint> points;  // that the map knows, as the frame sees them
  };

  // The frame with its image smoothed, as all of this sees it.
  FramePtr Prepare(LightFieldFrame frame);
  // The first frame, which may be in a map that was loaded.
  FrameResult Start(const FramePtr& frame);
  FrameResult StartSegment(FramePtr frame, const SE3& world_from_segment);
  // Recover, verified where motion does not expect what it finds.
  RecoveryResult RecoverInWindow(const LightFieldFrame& frame);
  FrameResult HandleLoss(FramePtr frame, TrackingStatus status);
  std::optional<Recognition> Recognize(const LightFieldFrame& frame);
  FramePtr WithKnownDepths(const LightFieldFrame& frame, const Recognition& recognition) const;
  // What the 1/v of the next frame are known to be too large by.
  double ExpectedDepthOffset() const;
  // Looks for the newest keyframe in the map, to join its segment to another, to place it better
  // than it was joined, or for loops.
  void FindKeyframe(FrameResult* result);
  std::vector<const Place*> PlacesToFind() const;
  std::optional<JoinedSegment> JoinSegment();
  std::vector<PlaceMatch> FindPlaces(const std::vector<const Place*>& places,
                                     const PlaceQuery& query) const;
  // What the alignment of a frame that becomes a keyframe knows, for Map::CloseLoops.
  void AddStepEdge(const LightFieldFrame& frame, const RecoveryResult& match);
  Place MakePlaceOf(const Window& window, const Keyframe& keyframe) const;
  // Of a segment that starts with the frame in process.
  NoiseModel InitialNoise() const;
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
  SegmentJoiner joiner_;
  std::vector<Sighting> sightings_;  // since the segment was joined
  int keyframes_to_settle_ = 0;      // that are still looked for
  RecentFrames recent_frames_;
  int next_keyframe_id_ = 0;
  int segment_ = 0;
  int lost_frames_ = 0;       // since the last that was tracked
  int unmatched_frames_ = 0;  // of those, that show something
  int held_frames_ = 0;       // in a row
  SE3 last_pose_;             // cam_from_world of the last tracked frame, as the window has it
  ImageF given_image_;        // of the frame in process, level 0 before smoothing
  double first_rms_ = 0;      // of the first frame tracked on the newest keyframe
};

}  // namespace prism
