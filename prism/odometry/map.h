// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "prism/scene/trajectory.h"
#include "prism/window/retirement.h"

namespace prism {

// A scene point in metres with its colour, gray where frames have none.
struct MapPoint {
  Eigen::Vector3d p_in_world = Eigen::Vector3d::Zero();
  std::array<uint8_t, 3> rgb{};
};

// What the odometry has found so far: poses of keyframes as they were when the window last held
// them, the frames that were tracked on them, and the points that have left the window.
class Map {
 public:
  // To be called whenever the window's keyframes have moved.
  void RememberKeyframes(const Window& window);
  // A frame tracked on a keyframe; a keyframe itself with the identity. Returns its index.
  size_t AddFrame(int64_t time_ns, int keyframe_id, const SE3& cam_from_keyframe);
  // Its pose relative to its keyframe is known better.
  void MoveFrame(size_t index, const SE3& cam_from_keyframe);
  void AddPoints(const std::vector<RetiredPoint>& points);

  // All tracked frames, each carried by the last pose of the keyframe it was tracked on.
  Trajectory FrameTrajectory() const;
  Trajectory KeyframeTrajectory() const;
  // Points that left the window and those in it, by the last poses of their keyframes.
  std::vector<MapPoint> Points(const Window& window) const;

 private:
  struct KeyframePose {
    int64_t time_ns = 0;
    SE3 cam_from_world;
  };
  struct TrackedFrame {
    int64_t time_ns;
    int keyframe_id;
    SE3 cam_from_keyframe;
  };
  std::map<int, KeyframePose> keyframes_;  // by id
  std::vector<TrackedFrame> frames_;
  std::vector<RetiredPoint> points_;
};

}  // namespace prism
