// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glog/logging.h>

namespace prism {

bool OdometryOptions::IsValid(std::string* error) const {
  if (!selection.IsValid(error) || !tracker.IsValid(error) || !keyframe.IsValid(error) ||
      !window.IsValid(error)) {
    return false;
  }
  if (max_new_points >= 1 && min_point_distance >= 1 && max_relative_sigma > 0 &&
      min_start_points >= 10) {
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

  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  TrackingResult tracking;
  {
    const StageTimer::Scope scope(&timer_, "track");
    tracking = tracker_.Track(frame->image);
  }
  const FrameAlignmentResult& alignment = tracking.alignment;
  if (tracking.status != TrackingStatus::kGood) {
    result.status = tracking.status == TrackingStatus::kNoTexture ? FrameStatus::kNoTexture
                                                                  : FrameStatus::kLost;
    return result;
  }
  const Keyframe& reference = window_.newest();
  result.status = FrameStatus::kTracked;
  result.rms = alignment.rms;
  result.points_used = alignment.inliers;
  result.keyframe_id = reference.id;
  // I_new = e^a I_ref + b and I_ref = e^(a_ref) L + b_ref.
  result.state = FrameState(alignment.state.target_from_reference * reference.state.pose(),
                            reference.state.a() + alignment.state.a,
                            std::exp(alignment.state.a) * reference.state.b() + alignment.state.b);
  if (NeedsKeyframe(alignment,
                    first_rms_,
                    camera_.focused_width(),
                    camera_.focused_height(),
                    options_.keyframe)) {
    MakeKeyframe(frame, &result);
  } else {
    if (first_rms_ == 0) first_rms_ = alignment.rms;
    tracked_frames_.push_back(
        {frame->time_ns, reference.id, alignment.state.target_from_reference});
  }
  result.active_points = window_.NumPoints();
  return result;
}

FrameResult Odometry::StartSegment(std::shared_ptr<const LightFieldFrame> frame) {
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->id = next_keyframe_id_;
  keyframe->frame = frame;
  window_.keyframes.push_back(std::move(keyframe));
  ActivatePoints();
  if (window_.NumPoints() < options_.min_start_points) {
    window_.keyframes.clear();
    result.status = FrameStatus::kNoTexture;
    return result;
  }
  ++next_keyframe_id_;
  AnchorFirstKeyframe(&window_);
  RememberKeyframePoses();
  tracked_frames_.push_back({frame->time_ns, window_.newest().id, SE3()});
  SetTrackingReference(SE3());
  result.status = FrameStatus::kTracked;
  result.is_keyframe = true;
  result.keyframe_id = window_.newest().id;
  result.active_points = window_.NumPoints();
  return result;
}

void Odometry::MakeKeyframe(std::shared_ptr<const LightFieldFrame> frame, FrameResult* result) {
  const SE3 old_reference = window_.newest().state.pose();
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
    SetTrackingReference(window_.newest().state.pose() * old_reference.Inverse());
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
  const Keyframe& newest = window_.newest();
  const size_t newest_index = window_.keyframes.size() - 1;
  const LightFieldFrame& frame = *newest.frame;
  CoverageMap coverage(window_);
  const int room = options_.window.max_points - window_.NumPoints();
  const bool is_first = window_.keyframes.size() == 1;
  const int wanted = is_first ? room : std::min(room, options_.max_new_points);
  const auto is_usable = [&](int x, int y) {
    return frame.sigma(x, y) > 0 && coverage.IsFree(x, y, options_.min_point_distance);
  };
  const std::vector<Eigen::Vector2i> pixels =
      SelectPoints(SquaredGradientMagnitude(frame.image[0]), wanted, is_usable, options_.selection);
  for (const Eigen::Vector2i& px : pixels) {
    auto point = std::make_unique<Point>();
    if (!MakePatch(frame.image[0], px.cast<double>(), options_.window.photometric, &point->patch)) {
      continue;
    }
    point->w_measured = frame.inverse_virtual_depth(px.x(), px.y());
    point->w_sigma = frame.sigma(px.x(), px.y());
    point->rho = std::max(InverseDepth(window_.camera, point->w_measured), 1e-3);
    const DepthRefinement refinement =
        RefineInverseDepth(window_, options_.window, newest_index, *point, options_.refinement);
    if (!refinement.success ||
        std::sqrt(refinement.rho_variance) > options_.max_relative_sigma * refinement.rho) {
      continue;
    }
    point->rho = refinement.rho;
    window_.newest().points.push_back(std::move(point));
  }
}

void Odometry::RetireKeyframes() {
  for (const int id : KeyframesToRetire(options_.window, options_.retirement, window_)) {
    RetirementResult retirement = RetireKeyframe(options_.window, id, &window_);
    retired_points_.insert(
        retired_points_.end(), retirement.points.begin(), retirement.points.end());
  }
}

void Odometry::SetTrackingReference(const SE3& new_from_old_reference) {
  const Keyframe& newest = window_.newest();
  std::vector<ReferencePoint> points;
  for (const auto& host : window_.keyframes) {
    const SE3 newest_from_host = newest.state.pose() * host->state.pose().Inverse();
    for (const auto& point : host->points) {
      if (host->id == newest.id) {
        points.push_back({point->patch.px, point->rho, 0});
        continue;
      }
      Eigen::Vector3d x_V;
      if (!IsObserved(window_, *host, *point, newest) ||
          !ProjectBetweenFrames(
              window_.camera, point->patch.px, point->rho, newest_from_host, &x_V)) {
        continue;
      }
      const double w = 1 / x_V.z();
      points.push_back({x_V.head<2>(), InverseDepth(window_.camera, w), 0});
    }
  }
  tracker_.SetReference(
      MakeTrackingReference(
          camera_, newest.frame->image, points, options_.window.photometric.gradient_constant),
      new_from_old_reference);
  first_rms_ = 0;
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
