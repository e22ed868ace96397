// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/metrics.h"

#include <cmath>

#include <gtest/gtest.h>

#include "test/eval/test_trajectory.h"

namespace prism {
namespace {

Sim3 SomeWorld(double scale) {
  Sim3 sim3;
  sim3.scale = scale;
  sim3.rigid = SE3(Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3), {3, -20, 0.5});
  return sim3;
}

// RMS distance of the positions from their mean.
double Spread(const Trajectory& trajectory) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : trajectory) mean += pose.world_from_cam.translation();
  mean /= static_cast<double>(trajectory.size());
  double sum = 0;
  for (const StampedPose& pose : trajectory) {
    sum += (pose.world_from_cam.translation() - mean).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(trajectory.size()));
}

TEST(Metrics, AreZeroForTheSamePathInAnotherWorld) {
  const Trajectory truth = CurvedTrajectory(300);
  const TrajectoryMetrics metrics = EvaluateTrajectory(truth, InWorldOf(truth, SomeWorld(1)));
  ASSERT_EQ(metrics.status, EvaluationStatus::kDone);
  EXPECT_EQ(metrics.matched_count, 300);
  EXPECT_NEAR(metrics.coverage_percent, 100, 1e-12);
  EXPECT_NEAR(metrics.ate_rmse_m, 0, 1e-12);
  EXPECT_NEAR(metrics.ate_max_m, 0, 1e-12);
  EXPECT_NEAR(metrics.sim3->ate_rmse_m, 0, 1e-12);
  EXPECT_NEAR(metrics.sim3->scale, 1, 1e-12);
  EXPECT_NEAR(metrics.sim3->d_s, 1, 1e-12);
  EXPECT_NEAR(metrics.relative_over_time->trans_rmse_m, 0, 1e-12);
  EXPECT_NEAR(metrics.loop->e_s, 1, 1e-9);
  EXPECT_NEAR(metrics.loop->e_align_m, 0, 1e-9);
}

TEST(Metrics, AWrongScaleLeavesTheSpreadTimesItsError) {
  const Trajectory truth = CurvedTrajectory(300);
  for (const double scale : {0.8, 1.25}) {
    const TrajectoryMetrics metrics = EvaluateTrajectory(truth, InWorldOf(truth, SomeWorld(scale)));
    ASSERT_EQ(metrics.status, EvaluationStatus::kDone);
    EXPECT_NEAR(metrics.sim3->scale, scale, 1e-12);
    EXPECT_NEAR(metrics.sim3->scale_error_percent, 100 * std::log(1.25), 1e-9);
    EXPECT_NEAR(metrics.sim3->d_s, 1.25, 1e-12);
    EXPECT_NEAR(metrics.ate_rmse_m, std::abs(1 - 1 / scale) * Spread(truth), 1e-12);
    EXPECT_NEAR(metrics.sim3->ate_rmse_m, 0, 1e-12);
    EXPECT_NEAR(metrics.loop->e_s, 1, 1e-9) << "a constant factor is no drift";
  }
}

TEST(Metrics, ErrorsAcrossASquareAreTheirRms) {
  // The corners of a square, lifted and lowered in turn: no rigid motion undoes that.
  Trajectory truth;
  Trajectory estimate;
  const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d corner(corners[i][0], corners[i][1], 0);
    const Eigen::Vector3d lift(0, 0, i % 2 == 0 ? 0.1 : -0.1);
    truth.push_back({i * kTestInterval_ns, SE3(Eigen::Quaterniond::Identity(), corner)});
    estimate.push_back({i * kTestInterval_ns, SE3(Eigen::Quaterniond::Identity(), corner + lift)});
  }
  const TrajectoryMetrics metrics = EvaluateTrajectory(truth, estimate);
  ASSERT_EQ(metrics.status, EvaluationStatus::kDone);
  EXPECT_NEAR(metrics.ate_rmse_m, 0.1, 1e-12);
  EXPECT_NEAR(metrics.ate_median_m, 0.1, 1e-12);
  EXPECT_NEAR(metrics.ate_max_m, 0.1, 1e-12);
  EXPECT_NEAR(metrics.path_length_m, 6, 1e-12);
  // The minimum over s of 2 (1 - s)^2 + (0.1 s)^2.
  EXPECT_NEAR(metrics.sim3->scale, 2 / 2.01, 1e-12);
}

TEST(Metrics, CoverageIsTheShareOfGroundtruthWithAnEstimate) {
  const Trajectory truth = CurvedTrajectory(200);
  const Trajectory half(truth.begin() + 50, truth.begin() + 150);
  const TrajectoryMetrics metrics = EvaluateTrajectory(truth, half);
  EXPECT_EQ(metrics.matched_count, 100);
  EXPECT_NEAR(metrics.coverage_percent, 50, 1e-12);
  EXPECT_EQ(metrics.groundtruth_count, 200);
  EXPECT_EQ(metrics.estimate_count, 100);
}

TEST(Metrics, SegmentsAreCutAtGapsAndWhereTheCallerSays) {
  const Trajectory truth = CurvedTrajectory(300);
  Trajectory estimate = InWorldOf(truth, SomeWorld(1));
  const Trajectory other_world = InWorldOf(truth, SomeWorld(0.5));
  for (size_t i = 200; i < 300; ++i) estimate[i] = other_world[i];
  estimate.erase(estimate.begin() + 60, estimate.begin() + 100);  // 2 s
  EvaluationOptions options;
  options.segment_starts_ns = {200 * kTestInterval_ns};
  const TrajectoryMetrics metrics = EvaluateTrajectory(truth, estimate, options);
  ASSERT_EQ(metrics.segments.size(), 3u);
  const int counts[3] = {60, 100, 100};
  const double scales[3] = {1, 1, 0.5};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(metrics.segments[i].matched_count, counts[i]);
    EXPECT_NEAR(metrics.segments[i].scale.value(), scales[i], 1e-9);
  }
  EXPECT_NEAR(metrics.segments[1].ate_rmse_m.value(), 0, 1e-12);
  EXPECT_GT(metrics.segments[2].ate_rmse_m.value(), 0.1);
  EXPECT_EQ(metrics.segments[1].start_ns, 100 * kTestInterval_ns);
}

TEST(Metrics, SayWhyNothingCanBeEvaluated) {
  const Trajectory truth = CurvedTrajectory(50);
  Trajectory later = truth;
  for (StampedPose& pose : later) pose.time_ns += 3600 * int64_t{1000000000};
  EXPECT_EQ(EvaluateTrajectory(truth, later).status, EvaluationStatus::kNoOverlap);
  EXPECT_EQ(EvaluateTrajectory(truth, {}).status, EvaluationStatus::kNoOverlap);
  EXPECT_EQ(EvaluateTrajectory({}, truth).status, EvaluationStatus::kNoOverlap);
  const Trajectory two(truth.begin(), truth.begin() + 2);
  EXPECT_EQ(EvaluateTrajectory(truth, two).status, EvaluationStatus::kTooFewMatches);
}

TEST(Metrics, AnEstimateThatStandsStillHasAnErrorButNoScale) {
  const Trajectory truth = CurvedTrajectory(50);
  Trajectory resting = truth;
  for (StampedPose& pose : resting) pose.world_from_cam = SE3();
  const TrajectoryMetrics metrics = EvaluateTrajectory(truth, resting);
  ASSERT_EQ(metrics.status, EvaluationStatus::kDone);
  EXPECT_NEAR(metrics.ate_rmse_m, Spread(truth), 1e-12);
  EXPECT_FALSE(metrics.sim3.has_value());
}

}  // namespace
}  // namespace prism
