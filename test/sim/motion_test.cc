// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/motion.h"

#include <gtest/gtest.h>

namespace prism {
namespace {

Trajectory Generate(MotionKind kind, uint64_t seed = 1) {
  MotionOptions options;
  options.kind = kind;
  options.seed = seed;
  SimPath path;
  path.position = {-1, 0.5, 1.4};
  path.target = {2, 1, 1};
  return GenerateMotion(options, path).AtFrames();
}

double Distance(const SE3& a, const SE3& b) { return (a.translation() - b.translation()).norm(); }

TEST(MotionTest, ALoopEndsExactlyWhereItBegan) {
  const Trajectory poses = Generate(MotionKind::kLoop);
  const SE3 gap = poses.front().world_from_cam.Inverse() * poses.back().world_from_cam;
  EXPECT_LT(gap.Log().norm(), 1e-9);
  EXPECT_GT(Distance(poses[0].world_from_cam, poses[poses.size() / 2].world_from_cam), 0.5);
}

TEST(MotionTest, PureRotationHasNoTranslation) {
  const Trajectory poses = Generate(MotionKind::kRotation);
  double largest = 0;
  for (const StampedPose& pose : poses) {
    EXPECT_LT(Distance(pose.world_from_cam, poses[0].world_from_cam), 1e-12);
    largest =
        std::max(largest, RotationAngle(pose.world_from_cam * poses[0].world_from_cam.Inverse()));
  }
  EXPECT_GT(largest, 0.3);
}

TEST(MotionTest, WalkingForwardNearsTheTarget) {
  const Trajectory poses = Generate(MotionKind::kForward);
  const Eigen::Vector3d target(2, 1, 1);
  EXPECT_NEAR((poses.front().world_from_cam.translation() - target).norm() -
                  (poses.back().world_from_cam.translation() - target).norm(),
              SimPath().extent,
              0.03);
}

TEST(MotionTest, HandheldIsSmoothAndShakeIsNot) {
  const auto largest_step = [](const Trajectory& poses) {
    double largest = 0;
    for (size_t i = 1; i < poses.size(); ++i) {
      largest = std::max(largest, Distance(poses[i].world_from_cam, poses[i - 1].world_from_cam));
    }
    return largest;
  };
  const double handheld = largest_step(Generate(MotionKind::kHandheld));
  EXPECT_GT(handheld, 0.002);
  EXPECT_LT(handheld, 0.05);
  EXPECT_GT(largest_step(Generate(MotionKind::kShake)), 0.02);
}

TEST(MotionTest, TheCameraStartsAtThePathLookingAtItsTargetUpright) {
  const SE3 start = Generate(MotionKind::kForward)[0].world_from_cam;
  EXPECT_LT((start.translation() - Eigen::Vector3d(-1, 0.5, 1.4)).norm(), 0.02);
  const Eigen::Vector3d target = start.Inverse() * Eigen::Vector3d(2, 1, 1);
  EXPECT_GT(target.normalized().z(), 0.999);
  EXPECT_LT((start.rotation() * Eigen::Vector3d::UnitY()).z(), -0.9);  // y down
}

TEST(MotionTest, SeedsMatter) {
  const SE3 a = Generate(MotionKind::kHandheld, 1)[30].world_from_cam;
  EXPECT_EQ(Distance(a, Generate(MotionKind::kHandheld, 1)[30].world_from_cam), 0);
  EXPECT_GT(Distance(a, Generate(MotionKind::kHandheld, 2)[30].world_from_cam), 1e-3);
}

TEST(MotionTest, ATrajectoryIsFollowedThroughItsPosesAndStraightBetween) {
  Vector6d twist;
  twist << 0.2, 0, 0.1, 0, 0.3, 0;
  const Trajectory poses = {{0, SE3()}, {1000000000, SE3::Exp(twist)}};
  const CameraMotion motion = FollowTrajectory(poses);
  EXPECT_EQ(motion.frame_times_ns.size(), 2u);
  EXPECT_LT((motion.world_from_cam(0.25).Log() - 0.25 * twist).norm(), 1e-12);
  EXPECT_LT((motion.world_from_cam(1.0).Log() - twist).norm(), 1e-12);
  EXPECT_LT(motion.world_from_cam(-1).Log().norm(), 1e-15);
}

}  // namespace
}  // namespace prism
