// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "prism/eval/association.h"
#include "prism/geometry/alignment.h"
#include "prism/scene/trajectory.h"

namespace prism {

constexpr int64_t kTestInterval_ns = 50000000;  // 20 Hz

// A smooth curve that fills three dimensions, turning all the while.
inline Trajectory CurvedTrajectory(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = 0.05 * i;
    const Eigen::Quaterniond rotation(
        Eigen::AngleAxisd(0.3 * t, Eigen::Vector3d(1, 2, -1).normalized()));
    trajectory.push_back(
        {i * kTestInterval_ns,
         SE3(rotation, {std::sin(t), 0.5 * std::cos(1.3 * t), 0.2 * t + 0.1 * std::sin(3 * t)})});
  }
  return trajectory;
}

// The trajectory as a system would see it whose world is another: gt_from_estimate takes each
// returned position to the given one.
inline Trajectory InWorldOf(const Trajectory& trajectory, const Sim3& gt_from_estimate) {
  const SE3 estimate_from_gt = gt_from_estimate.rigid.Inverse();
  Trajectory moved;
  for (const StampedPose& pose : trajectory) {
    const SE3 rotated = estimate_from_gt * pose.world_from_cam;
    moved.push_back(
        {pose.time_ns, SE3(rotated.rotation(), rotated.translation() / gt_from_estimate.scale)});
  }
  return moved;
}

// Pairs of two trajectories of one length, pose by pose.
inline std::vector<PosePair> Pairs(const Trajectory& groundtruth, const Trajectory& estimate) {
  std::vector<PosePair> pairs;
  for (size_t i = 0; i < groundtruth.size(); ++i) {
    pairs.push_back(
        {groundtruth[i].time_ns, groundtruth[i].world_from_cam, estimate[i].world_from_cam});
  }
  return pairs;
}

}  // namespace prism
