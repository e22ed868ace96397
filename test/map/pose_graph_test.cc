// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/pose_graph.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

constexpr int kPoses = 20;

// Once around a circle of 1 m, looking outwards.
SE3 TruePose(int i) {
  const double angle = 2 * M_PI * i / (kPoses - 1);
  return SE3::Exp((Vector6d() << 0, 0, 0, 0, angle, 0).finished()) *
         SE3(Eigen::Quaterniond::Identity(), {0, 0, 1});
}

struct Loop {
  std::map<int, SE3> poses;  // as odometry has them
  std::vector<PoseEdge> edges;
};

// Steps measured with an error each, poses by dead reckoning.
Loop DriftingLoop(unsigned seed) {
  std::mt19937_64 generator = SeededGenerator(seed, 0);
  std::normal_distribution<double> normal;
  Loop loop;
  loop.poses[0] = TruePose(0);
  for (int i = 1; i < kPoses; ++i) {
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = 0.004 * normal(generator);
    const SE3 step = SE3::Exp(error) * TruePose(i) * TruePose(i - 1).Inverse();
    loop.edges.push_back({i - 1, i, step, 1 / (0.004 * 0.004) * Matrix6d::Identity()});
    loop.poses[i] = step * loop.poses[i - 1];
  }
  return loop;
}

PoseEdge LoopEdge(const SE3& error) {
  return {0,
          kPoses - 1,
          error * TruePose(kPoses - 1) * TruePose(0).Inverse(),
          1 / (0.001 * 0.001) * Matrix6d::Identity(),
          true};
}

double LargestError(const std::map<int, SE3>& poses) {
  double largest = 0;
  for (const auto& [id, pose] : poses) {
    largest = std::max(
        largest, (pose.Inverse().translation() - TruePose(id).Inverse().translation()).norm());
  }
  return largest;
}

TEST(PoseGraph, ClosingALoopSpreadsTheDriftOverIt) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    Loop loop = DriftingLoop(seed);
    const SE3 end_before = loop.poses.at(kPoses - 1);
    loop.edges.push_back(LoopEdge(SE3()));
    OptimizePoses(loop.edges, {0}, &loop.poses);
    const auto end_error = [](const SE3& pose) {
      return (pose * TruePose(kPoses - 1).Inverse()).Log().norm();
    };
    EXPECT_LT(end_error(loop.poses.at(kPoses - 1)), 0.3 * end_error(end_before)) << seed;
    EXPECT_EQ((loop.poses.at(0) * TruePose(0).Inverse()).Log().norm(), 0) << "held";
  }
}

TEST(PoseGraph, WithoutALoopNothingMoves) {
  Loop loop = DriftingLoop(3);
  const std::map<int, SE3> before = loop.poses;
  OptimizePoses(loop.edges, {0}, &loop.poses);
  for (const auto& [id, pose] : before) {
    EXPECT_LT((loop.poses.at(id) * pose.Inverse()).Log().norm(), 1e-7) << id;
  }
}

TEST(PoseGraph, AFalseLoopAmongTrueOnesIsHardlyFollowed) {
  Loop loop = DriftingLoop(1);
  loop.edges.push_back(LoopEdge(SE3()));
  OptimizePoses(loop.edges, {0}, &loop.poses);
  const double without = LargestError(loop.poses);
  PoseEdge wrong = LoopEdge(SE3());
  wrong.from = 2;
  wrong.to = 11;
  wrong.to_from_from = SE3();  // opposite sides of the circle
  loop.edges.push_back(wrong);
  OptimizePoses(loop.edges, {0}, &loop.poses);
  EXPECT_LT(LargestError(loop.poses), without + 0.01);
}

}  // namespace
}  // namespace prism
