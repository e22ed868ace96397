// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/association.h"

#include <algorithm>
#include <cstdlib>

#include <glog/logging.h>

namespace prism {
namespace {

constexpr int64_t kTimeRounding_ns = 1000;

bool IsNear(const StampedPose& a, const StampedPose& b, int64_t max_difference_ns) {
  return std::abs(a.time_ns - b.time_ns) <= max_difference_ns;
}

template <typename Member>
std::vector<Eigen::Vector3d> Positions(const std::vector<PosePair>& pairs, Member member) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(pairs.size());
  for (const PosePair& pair : pairs) positions.push_back((pair.*member).translation());
  return positions;
}

}  // namespace

int64_t MedianInterval(const Trajectory& trajectory) {
  if (trajectory.size() < 2) return 0;
  std::vector<int64_t> intervals;
  intervals.reserve(trajectory.size() - 1);
  for (size_t i = 1; i < trajectory.size(); ++i) {
    intervals.push_back(trajectory[i].time_ns - trajectory[i - 1].time_ns);
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

int64_t HalfFrame(const Trajectory& groundtruth, const Trajectory& estimate) {
  const int64_t a = MedianInterval(groundtruth);
  const int64_t b = MedianInterval(estimate);
  const int64_t interval = a == 0 || b == 0 ? std::max(a, b) : std::min(a, b);
  return interval / 2 + kTimeRounding_ns;
}

size_t NearestPose(const Trajectory& trajectory, int64_t time_ns) {
  CHECK(!trajectory.empty());
  const auto after = std::lower_bound(
      trajectory.begin(), trajectory.end(), time_ns, [](const StampedPose& pose, int64_t time) {
        return pose.time_ns < time;
      });
  const auto index = static_cast<size_t>(after - trajectory.begin());
  if (index == 0) return 0;
  if (index == trajectory.size()) return index - 1;
  const int64_t to_next = trajectory[index].time_ns - time_ns;
  const int64_t to_previous = time_ns - trajectory[index - 1].time_ns;
  return to_previous <= to_next ? index - 1 : index;
}

std::vector<PosePair> Associate(const Trajectory& groundtruth,
                                const Trajectory& estimate,
                                int64_t max_difference_ns) {
  std::vector<PosePair> pairs;
  if (groundtruth.empty()) return pairs;
  for (size_t i = 0; i < estimate.size(); ++i) {
    const StampedPose& truth = groundtruth[NearestPose(groundtruth, estimate[i].time_ns)];
    if (!IsNear(truth, estimate[i], max_difference_ns)) continue;
    if (NearestPose(estimate, truth.time_ns) != i) continue;
    pairs.push_back({estimate[i].time_ns, truth.world_from_cam, estimate[i].world_from_cam});
  }
  return pairs;
}

int CountCovered(const Trajectory& groundtruth,
                 const Trajectory& estimate,
                 int64_t max_difference_ns) {
  if (estimate.empty()) return 0;
  return static_cast<int>(
      std::count_if(groundtruth.begin(), groundtruth.end(), [&](const StampedPose& truth) {
        return IsNear(truth, estimate[NearestPose(estimate, truth.time_ns)], max_difference_ns);
      }));
}

std::vector<Eigen::Vector3d> GroundtruthPositions(const std::vector<PosePair>& pairs) {
  return Positions(pairs, &PosePair::groundtruth);
}

std::vector<Eigen::Vector3d> EstimatePositions(const std::vector<PosePair>& pairs) {
  return Positions(pairs, &PosePair::estimate);
}

}  // namespace prism
