// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/map.h"

namespace prism {

void Map::RememberKeyframes(const Window& window) {
  for (const auto& keyframe : window.keyframes) {
    keyframes_[keyframe->id] = {keyframe->frame->time_ns, keyframe->state.pose()};
  }
}

size_t Map::AddFrame(int64_t time_ns, int keyframe_id, const SE3& cam_from_keyframe) {
  frames_.push_back({time_ns, keyframe_id, cam_from_keyframe});
  return frames_.size() - 1;
}

void Map::MoveFrame(size_t index, const SE3& cam_from_keyframe) {
  frames_.at(index).cam_from_keyframe = cam_from_keyframe;
}

void Map::AddPoints(const std::vector<RetiredPoint>& points) {
  points_.insert(points_.end(), points.begin(), points.end());
}

Trajectory Map::FrameTrajectory() const {
  Trajectory trajectory;
  for (const TrackedFrame& frame : frames_) {
    const SE3 cam_from_world =
        frame.cam_from_keyframe * keyframes_.at(frame.keyframe_id).cam_from_world;
    trajectory.push_back({frame.time_ns, cam_from_world.Inverse()});
  }
  return trajectory;
}

Trajectory Map::KeyframeTrajectory() const {
  Trajectory trajectory;
  for (const auto& [id, keyframe] : keyframes_) {
    trajectory.push_back({keyframe.time_ns, keyframe.cam_from_world.Inverse()});
  }
  return trajectory;
}

std::vector<MapPoint> Map::Points(const Window& window) const {
  std::vector<MapPoint> points;
  const auto add = [&](const RetiredPoint& point) {
    points.push_back(
        {keyframes_.at(point.keyframe_id).cam_from_world.Inverse() * point.x_C, point.rgb});
  };
  for (const RetiredPoint& point : points_) add(point);
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) {
      add(MakeRetiredPoint(window.camera, *keyframe, *point));
    }
  }
  return points;
}

}  // namespace prism
