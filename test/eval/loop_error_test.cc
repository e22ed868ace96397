// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/loop_error.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "test/eval/test_trajectory.h"

namespace prism {
namespace {

// The first half of the curve in the world of `start`, the second in that of `end`.
Trajectory Drifting(const Trajectory& truth, const Sim3& start, const Sim3& end) {
  Trajectory estimate = InWorldOf(truth, start);
  const Trajectory late = InWorldOf(truth, end);
  for (size_t i = truth.size() / 2; i < truth.size(); ++i) estimate[i] = late[i];
  return estimate;
}

TEST(LoopError, ReportsScaleAndRotationBetweenStartAndEnd) {
  const Trajectory truth = CurvedTrajectory(400);
  Sim3 start;
  start.scale = 1.1;
  Sim3 end;
  end.scale = 0.8;
  end.rigid = SE3(Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY())), {1, 2, 3});
  const Trajectory estimate = Drifting(truth, start, end);
  const auto error = ComputeLoopError(Pairs(truth, estimate), estimate, 60);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->scale_start, 1.1, 1e-9);
  EXPECT_NEAR(error->scale_end, 0.8, 1e-9);
  EXPECT_NEAR(error->e_s, 1.1 / 0.8, 1e-9);
  EXPECT_NEAR(error->e_r_deg, 0.2 * 180 / M_PI, 1e-7);

  std::swap(start, end);
  const Trajectory swapped = Drifting(truth, start, end);
  EXPECT_NEAR(ComputeLoopError(Pairs(truth, swapped), swapped, 60)->e_s, 1.1 / 0.8, 1e-9);
}

TEST(LoopError, AlignmentErrorOfAShiftIsItsLength) {
  const Trajectory truth = CurvedTrajectory(400);
  Sim3 shifted;
  shifted.rigid = SE3(Eigen::Quaterniond::Identity(), {0.3, 0, -0.4});
  const Trajectory estimate = Drifting(truth, Sim3(), shifted);
  const auto error = ComputeLoopError(Pairs(truth, estimate), estimate, 60);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->e_align_m, 0.5, 1e-9);
  EXPECT_NEAR(error->e_s, 1, 1e-9);
}

TEST(LoopError, NeedsGroundtruthAtBothEndsOnly) {
  const Trajectory truth = CurvedTrajectory(400);
  Sim3 shifted;
  shifted.rigid = SE3(Eigen::Quaterniond::Identity(), {0, 0.25, 0});
  const Trajectory estimate = Drifting(truth, Sim3(), shifted);
  std::vector<PosePair> pairs = Pairs(truth, estimate);
  pairs.erase(pairs.begin() + 60, pairs.end() - 60);
  const auto error = ComputeLoopError(pairs, estimate, 60);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->e_align_m, 0.25, 1e-9);
}

TEST(LoopError, IsNothingForShortOrResting) {
  const Trajectory truth = CurvedTrajectory(20);
  EXPECT_FALSE(ComputeLoopError(Pairs(truth, truth), truth, 11).has_value());
  EXPECT_FALSE(ComputeLoopError(Pairs(truth, truth), truth, 2).has_value());
  const Trajectory resting(20, StampedPose{});
  EXPECT_FALSE(ComputeLoopError(Pairs(truth, resting), resting, 8).has_value());
}

}  // namespace
}  // namespace prism
