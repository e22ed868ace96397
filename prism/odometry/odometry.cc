// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glog/logging.h>

#include "prism/image/noise.h"

namespace prism {

bool OdometryOptions::IsValid(std::string* error) const {
  if (!selection.IsValid(error) || !tracker.IsValid(error) || !keyframe.IsValid(error) ||
      !window.IsValid(error) || !candidates.IsValid(error)) {
    return false;
  }
  if (max_new_points >= 1 && min_point_distance >= 1 && min_start_points >= 10 &&
      max_lost_frames >= 1) {
    return true;
  }
  *error = "activation needs a point or more, a distance of 1 px or more and 10 points to start";
  return false;
}

const char* ToString(FrameStatus status) {
  switch (status) {
    case FrameStatus::kTracked:
      return "tracked";
    case FrameStatus::kNoTexture:
      return "no texture";
    case FrameStatus::kLost:
      return "lost";
  }
  return "";
}

Odometry::Odometry(const PlenopticCamera& camera, const OdometryOptions& options)
    : camera_(camera),
      options_(options),
      window_(PlenopticProjection(camera)),
      tracker_(options.tracker) {
  std::string error;
  CHECK(options_.IsValid(&error)) << error;
}

FrameResult Odometry::Process(LightFieldFrame light_field_frame) {
  const auto frame = std::make_shared<const LightFieldFrame>(std::move(light_field_frame));
  CHECK(frame->image.at(0).width() == window_.camera.width &&
        frame->image.at(0).height() == window_.camera.height);
  if (window_.empty()) return StartSegment(frame);

  TrackingResult tracking;
  const Keyframe* reference = Track(*frame, &tracking);
  if (reference == nullptr) return HandleLoss(frame, tracking.status);

  const FrameAlignmentResult& alignment = tracking.alignment;
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  result.status = FrameStatus::kTracked;
  result.rms = alignment.rms;
  result.points_used = alignment.inliers;
  result.keyframe_id = reference->id;
  // I_new = e^a I_ref + b and I_ref = e^(a_ref) L + b_ref.
  result.state = FrameState(alignment.state.target_from_reference * reference->state.pose(),
                            reference->state.a() + alignment.state.a,
                            std::exp(alignment.state.a) * reference->state.b() + alignment.state.b);
  {
    const StageTimer::Scope scope(&timer_, "update candidates");
    UpdateCandidates(options_.candidates, frame->image[0], result.state, &window_);
  }
  const bool is_recovered = reference != &window_.newest();
  if (is_recovered || NeedsKeyframe(alignment,
                                    first_rms_,
                                    camera_.focused_width(),
                                    camera_.focused_height(),
                                    options_.keyframe)) {
    MakeKeyframe(frame, reference->state.pose(), &result);
  } else {
    if (first_rms_ == 0) first_rms_ = alignment.rms;
    tracked_frames_.push_back(
        {frame->time_ns, reference->id, alignment.state.target_from_reference});
  }
  lost_frames_ = 0;
  last_pose_ = result.state.pose();
  result.active_points = window_.NumPoints();
  return result;
}

const Keyframe* Odometry::Track(const LightFieldFrame& frame, TrackingResult* tracking) {
  const StageTimer::Scope scope(&timer_, "track");
  if (lost_frames_ == 0) {
    *tracking = tracker_.Track(frame.image);
    return tracking->status == TrackingStatus::kGood ? &window_.newest() : nullptr;
  }
  for (size_t i = window_.keyframes.size(); i-- > 0;) {
    const Keyframe& keyframe = *window_.keyframes[i];
    Tracker recovery = tracker_;
    recovery.SetReference(MakeReference(keyframe),
                          keyframe.state.pose() * window_.newest().state.pose().Inverse());
    *tracking = recovery.Track(frame.image);
    if (tracking->status == TrackingStatus::kNoTexture) return nullptr;
    if (tracking->status != TrackingStatus::kGood) continue;
    if (IsCredible(frame, keyframe, tracking->alignment)) {
      tracker_ = std::move(recovery);
      return &keyframe;
    }
    tracking->status = TrackingStatus::kLost;
  }
  return nullptr;
}

bool Odometry::IsCredible(const LightFieldFrame& frame,
                          const Keyframe& keyframe,
                          const FrameAlignmentResult& alignment) const {
  const RecoveryOptions& recovery = options_.recovery;
  const SE3 pose = alignment.state.target_from_reference * keyframe.state.pose();
  return (!tracker_.KnowsFit() ||
          alignment.rms <= recovery.max_rms_ratio * tracker_.TypicalRms()) &&
         alignment.outlier_fraction <= recovery.max_outlier_fraction &&
         alignment.visible_fraction >= recovery.min_visible_fraction &&
         std::abs(alignment.state.a) <= recovery.max_log_gain &&
         DepthAgreement(window_, frame, pose) >= recovery.min_depth_agreement;
}

FrameResult Odometry::HandleLoss(FramePtr frame, TrackingStatus status) {
  ++lost_frames_;
  if (lost_frames_ > options_.max_lost_frames && status != TrackingStatus::kNoTexture) {
    // Everything the window holds goes to the map; the new segment knows nothing of it.
    while (!window_.empty()) {
      RetirementResult retirement = ForgetOldestKeyframe(&window_);
      retired_points_.insert(
          retired_points_.end(), retirement.points.begin(), retirement.points.end());
    }
    ++segment_;
    return StartSegment(std::move(frame));
  }
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  result.status =
      status == TrackingStatus::kNoTexture ? FrameStatus::kNoTexture : FrameStatus::kLost;
  return result;
}

FrameResult Odometry::StartSegment(FramePtr frame) {
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->id = next_keyframe_id_;
  keyframe->frame = std::move(frame);
  keyframe->state = FrameState(last_pose_, 0, 0);
  const double noise = EstimateImageNoise(keyframe->frame->image[0]);
  options_.window.photometric.intensity_sigma =
      std::hypot(std::sqrt(2.0) * noise, options_.photometric_model_sigma);
  window_.keyframes.push_back(std::move(keyframe));
  ActivatePoints();
  if (window_.NumPoints() < options_.min_start_points) {
    window_.keyframes.clear();
    result.status = FrameStatus::kNoTexture;
    return result;
  }
  ++next_keyframe_id_;
  lost_frames_ = 0;
  AnchorFirstKeyframe(&window_);
  RememberKeyframePoses();
  tracked_frames_.push_back({window_.newest().frame->time_ns, window_.newest().id, SE3()});
  tracker_.Reset();
  tracker_.SetReference(MakeReference(window_.newest()), SE3());
  first_rms_ = 0;
  result.status = FrameStatus::kTracked;
  result.is_keyframe = true;
  result.keyframe_id = window_.newest().id;
  result.state = window_.newest().state;
  result.active_points = window_.NumPoints();
  return result;
}

void Odometry::MakeKeyframe(FramePtr frame, const SE3& reference_pose, FrameResult* result) {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->id = next_keyframe_id_++;
  keyframe->frame = std::move(frame);
  keyframe->state = result->state;
  window_.keyframes.push_back(std::move(keyframe));
  {
    const StageTimer::Scope scope(&timer_, "activate points");
    ActivatePoints();
  }
  {
    const StageTimer::Scope scope(&timer_, "optimize window");
    result->optimization = OptimizeWindow(options_.window, &window_);
  }
  {
    const StageTimer::Scope scope(&timer_, "remove outliers");
    RemoveOutliers(options_.window, options_.outliers, &window_);
  }
  RememberKeyframePoses();
  {
    const StageTimer::Scope scope(&timer_, "set reference");
    tracker_.SetReference(MakeReference(window_.newest()),
                          window_.newest().state.pose() * reference_pose.Inverse());
    first_rms_ = 0;
  }
  {
    const StageTimer::Scope scope(&timer_, "marginalize");
    RetireKeyframes();
  }
  result->is_keyframe = true;
  result->keyframe_id = window_.newest().id;
  result->state = window_.newest().state;
  tracked_frames_.push_back({window_.newest().frame->time_ns, window_.newest().id, SE3()});
}

void Odometry::ActivatePoints() {
  const size_t newest_index = window_.keyframes.size() - 1;
  Keyframe& newest = window_.newest();
  const LightFieldFrame& frame = *newest.frame;
  CoverageMap coverage(window_);
  int room = options_.window.max_points - window_.NumPoints();
  if (newest_index > 0) {
    room = std::min(room, options_.max_new_points);
    room -= ActivateCandidates(options_.window,
                               options_.candidates,
                               options_.refinement,
                               options_.min_point_distance,
                               room,
                               &coverage,
                               &window_);
  }
  const ImageF squared_gradient = SquaredGradientMagnitude(frame.image[0]);
  const auto select = [&](int count, bool with_depth) {
    const auto is_usable = [&](int x, int y) {
      return (frame.sigma(x, y) > 0) == with_depth &&
             coverage.IsFree(x, y, options_.min_point_distance);
    };
    return SelectPoints(squared_gradient, count, is_usable, options_.selection);
  };
  Candidate candidate;
  for (const Eigen::Vector2i& px : select(room, /*with_depth=*/true)) {
    if (MakeCandidate(window_, options_.window, options_.candidates, newest, px, &candidate)) {
      ActivateCandidate(options_.window, options_.refinement, newest_index, candidate, &window_);
    }
  }
  // Where nothing was measured, motion alone has to tell.
  for (const Eigen::Vector2i& px :
       select(options_.candidates.max_per_keyframe, /*with_depth=*/false)) {
    if (MakeCandidate(window_, options_.window, options_.candidates, newest, px, &candidate)) {
      newest.candidates.push_back(candidate);
    }
  }
}

void Odometry::RetireKeyframes() {
  for (const int id : KeyframesToRetire(options_.window, options_.retirement, window_)) {
    RetirementResult retirement = RetireKeyframe(options_.window, id, &window_);
    retired_points_.insert(
        retired_points_.end(), retirement.points.begin(), retirement.points.end());
  }
}

TrackingReference Odometry::MakeReference(const Keyframe& reference) const {
  std::vector<ReferencePoint> points;
  for (const auto& host : window_.keyframes) {
    const SE3 reference_from_host = reference.state.pose() * host->state.pose().Inverse();
    for (const auto& point : host->points) {
      if (host->id == reference.id) {
        points.push_back({point->patch.px, point->rho});
        continue;
      }
      Eigen::Vector3d x_V;
      if (IsObserved(window_, *host, *point, reference) &&
          ProjectBetweenFrames(
              window_.camera, point->patch.px, point->rho, reference_from_host, &x_V)) {
        points.push_back({x_V.head<2>(), InverseDepth(window_.camera, 1 / x_V.z())});
      }
    }
  }
  return MakeTrackingReference(
      camera_, reference.frame->image, points, options_.window.photometric.gradient_constant);
}

void Odometry::RememberKeyframePoses() {
  for (const auto& keyframe : window_.keyframes) {
    keyframe_poses_[keyframe->id] = {keyframe->frame->time_ns, keyframe->state.pose()};
  }
}

Trajectory Odometry::FrameTrajectory() const {
  Trajectory trajectory;
  for (const TrackedFrame& frame : tracked_frames_) {
    const SE3 cam_from_world =
        frame.cam_from_keyframe * keyframe_poses_.at(frame.keyframe_id).cam_from_world;
    trajectory.push_back({frame.time_ns, cam_from_world.Inverse()});
  }
  return trajectory;
}

Trajectory Odometry::KeyframeTrajectory() const {
  Trajectory trajectory;
  for (const auto& [id, keyframe] : keyframe_poses_) {
    trajectory.push_back({keyframe.time_ns, keyframe.cam_from_world.Inverse()});
  }
  return trajectory;
}

std::vector<MapPoint> Odometry::MapPoints() const {
  std::vector<MapPoint> points;
  const auto add = [&](int keyframe_id, const Eigen::Vector3d& x_C, float intensity) {
    points.push_back({keyframe_poses_.at(keyframe_id).cam_from_world.Inverse() * x_C, intensity});
  };
  for (const RetiredPoint& point : retired_points_) {
    add(point.keyframe_id, point.x_C, point.intensity);
  }
  constexpr int kCenter = 4;  // of kPattern
  for (const auto& keyframe : window_.keyframes) {
    for (const auto& point : keyframe->points) {
      add(keyframe->id,
          UnprojectInverseDepth(window_.camera, point->patch.px, point->rho),
          point->patch.intensity[kCenter]);
    }
  }
  return points;
}

}  // namespace prism
