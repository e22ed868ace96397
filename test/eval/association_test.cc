// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/association.h"

#include <gtest/gtest.h>

namespace prism {
namespace {

Trajectory AtTimes(const std::vector<int64_t>& times_ns) {
  Trajectory trajectory;
  for (const int64_t time_ns : times_ns) {
    const Eigen::Vector3d position(static_cast<double>(time_ns), 0, 0);
    trajectory.push_back({time_ns, SE3(Eigen::Quaterniond::Identity(), position)});
  }
  return trajectory;
}

TEST(Association, HalfFrameIsHalfTheSmallerMedianInterval) {
  const Trajectory fast = AtTimes({0, 10000000, 20000000, 90000000});
  const Trajectory slow = AtTimes({0, 40000000, 80000000});
  EXPECT_EQ(HalfFrame(fast, slow), 5000000 + 1000);
  EXPECT_EQ(HalfFrame(slow, fast), 5000000 + 1000);
  EXPECT_EQ(HalfFrame(slow, AtTimes({7})), 20000000 + 1000);
}

TEST(Association, NearestPoseIsFoundAtBothEndsAndBetween) {
  const Trajectory trajectory = AtTimes({10, 20, 40});
  EXPECT_EQ(NearestPose(trajectory, -5), 0u);
  EXPECT_EQ(NearestPose(trajectory, 10), 0u);
  EXPECT_EQ(NearestPose(trajectory, 15), 0u);
  EXPECT_EQ(NearestPose(trajectory, 16), 1u);
  EXPECT_EQ(NearestPose(trajectory, 31), 2u);
  EXPECT_EQ(NearestPose(trajectory, 99), 2u);
}

TEST(Association, PairsAreMutuallyNearestAndEachPoseIsUsedOnce) {
  const Trajectory truth = AtTimes({0, 100, 200, 300});
  const Trajectory estimate = AtTimes({-2, 3, 98, 160, 304});
  const std::vector<PosePair> pairs = Associate(truth, estimate, 10);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].time_ns, -2);
  EXPECT_EQ(pairs[1].time_ns, 98);
  EXPECT_EQ(pairs[2].time_ns, 304);
  EXPECT_EQ(pairs[1].groundtruth.translation().x(), 100);
  EXPECT_EQ(pairs[1].estimate.translation().x(), 98);
}

TEST(Association, TrajectoriesApartInTimeHaveNoPair) {
  EXPECT_TRUE(Associate(AtTimes({0, 100}), AtTimes({5000, 5100}), 50).empty());
  EXPECT_TRUE(Associate({}, AtTimes({0}), 50).empty());
  EXPECT_TRUE(Associate(AtTimes({0}), {}, 50).empty());
}

TEST(Association, CoverageCountsGroundtruthPosesWithAnEstimate) {
  const Trajectory truth = AtTimes({0, 100, 200, 300});
  EXPECT_EQ(CountCovered(truth, AtTimes({1, 102, 150}), 10), 2);
  EXPECT_EQ(CountCovered(truth, {}, 10), 0);
}

}  // namespace
}  // namespace prism
