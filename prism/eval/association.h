// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "prism/scene/trajectory.h"

namespace prism {

// A ground-truth pose and the estimate of it. The two trajectories have worlds of their own.
struct PosePair {
  int64_t time_ns = 0;  // of the estimate
  SE3 groundtruth;      // world_from_cam
  SE3 estimate;         // world_from_cam
};

// Median time from pose to pose in ns; 0 for fewer than two poses.
int64_t MedianInterval(const Trajectory& trajectory);

// Half a frame: half the smaller of the two median intervals, and a microsecond more for times that
// were rounded to that. Where one trajectory has fewer than two poses the other one decides.
int64_t HalfFrame(const Trajectory& groundtruth, const Trajectory& estimate);

// Index of the pose of a non-empty trajectory whose time is nearest to time_ns; the earlier of two
// equally near.
size_t NearestPose(const Trajectory& trajectory, int64_t time_ns);

// Pairs by time, in order of time: an estimate and a ground-truth pose are a pair if each is the
// other's nearest and they are at most max_difference_ns apart. No pose is used twice.
std::vector<PosePair> Associate(const Trajectory& groundtruth,
                                const Trajectory& estimate,
                                int64_t max_difference_ns);

// Number of ground-truth poses with an estimate at most max_difference_ns away.
int CountCovered(const Trajectory& groundtruth,
                 const Trajectory& estimate,
                 int64_t max_difference_ns);

// Camera centres in the respective world.
std::vector<Eigen::Vector3d> GroundtruthPositions(const std::vector<PosePair>& pairs);
std::vector<Eigen::Vector3d> EstimatePositions(const std::vector<PosePair>& pairs);

}  // namespace prism
