// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/relative_error.h"

#include <cmath>

#include <gtest/gtest.h>

#include "test/eval/test_trajectory.h"

namespace prism {
namespace {

constexpr int64_t kSecond_ns = 1000000000;

// Straight on along x at 0.4 m/s times `factor`, turning by `turn_deg_per_s` about x.
Trajectory Straight(int count, double factor, double turn_deg_per_s) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = 0.05 * i;
    const Eigen::Quaterniond rotation(
        Eigen::AngleAxisd(turn_deg_per_s * t * M_PI / 180, Eigen::Vector3d::UnitX()));
    trajectory.push_back({i * kTestInterval_ns, SE3(rotation, {0.4 * factor * t, 0, 0})});
  }
  return trajectory;
}

TEST(RelativeError, OverTimeIsTheDriftOfOneInterval) {
  const auto pairs = Pairs(Straight(100, 1, 0), Straight(100, 1.03, 2));
  const auto error = RelativeErrorOverTime(pairs, kSecond_ns, kTestInterval_ns / 2);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->count, 80);
  EXPECT_NEAR(error->trans_rmse_m, 0.4 * 0.03, 1e-12);
  EXPECT_NEAR(error->rot_rmse_deg, 2, 1e-9);
}

TEST(RelativeError, OverDistanceIsTheDriftOfThatLength) {
  // 0.02 m from pose to pose; a length that ends between two poses is taken to the later one.
  const auto pairs = Pairs(Straight(100, 1, 0), Straight(100, 0.95, -3));
  const auto error = RelativeErrorOverDistance(pairs, 0.99);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->count, 50);
  EXPECT_NEAR(error->trans_rmse_m, 1.0 * 0.05, 1e-12);
  EXPECT_NEAR(error->rot_rmse_deg, 3 * 2.5, 1e-9);
}

TEST(RelativeError, DoesNotDependOnTheWorldsOfTheTrajectories) {
  Sim3 world;
  world.rigid = SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {10, -4, 7});
  const Trajectory truth = CurvedTrajectory(120);
  const auto error = RelativeErrorOverTime(
      Pairs(truth, InWorldOf(truth, world)), kSecond_ns, kTestInterval_ns / 2);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->trans_rmse_m, 0, 1e-12);
  EXPECT_NEAR(error->rot_rmse_deg, 0, 1e-6);
}

TEST(RelativeError, IsNothingForTrajectoriesThatAreTooShort) {
  const auto pairs = Pairs(Straight(15, 1, 0), Straight(15, 1, 0));
  EXPECT_FALSE(RelativeErrorOverTime(pairs, kSecond_ns, kTestInterval_ns / 2).has_value());
  EXPECT_FALSE(RelativeErrorOverDistance(pairs, 1).has_value());
  EXPECT_FALSE(RelativeErrorOverTime({}, kSecond_ns, kTestInterval_ns / 2).has_value());
}

TEST(RelativeError, SkipsPairsAcrossAGapInTime) {
  auto pairs = Pairs(Straight(100, 1, 0), Straight(100, 1.03, 0));
  pairs.erase(pairs.begin() + 30, pairs.begin() + 60);
  const auto error = RelativeErrorOverTime(pairs, kSecond_ns, kTestInterval_ns / 2);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->count, 10 + 20);
  EXPECT_NEAR(error->trans_rmse_m, 0.4 * 0.03, 1e-12);
}

}  // namespace
}  // namespace prism
