// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/geometry/alignment.h"

#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "test/geometry/random_se3.h"

namespace prism {
namespace {

std::vector<Eigen::Vector3d> RandomPoints(int count, std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points(count);
  for (Eigen::Vector3d& p : points) {
    p = {normal(*generator), normal(*generator), normal(*generator)};
  }
  return points;
}

TEST(AlignPoints, RecoversASimilarityExactly) {
  std::mt19937_64 generator = SeededGenerator(7, 0);
  const std::vector<Eigen::Vector3d> source = RandomPoints(20, &generator);
  const Sim3 truth{1.7, RandomSE3(&generator)};
  std::vector<Eigen::Vector3d> target;
  for (const Eigen::Vector3d& p : source) target.push_back(truth * p);
  const AlignmentResult result = AlignPoints(source, target, true);
  ASSERT_TRUE(result.success);
  EXPECT_NEAR(result.target_from_source.scale, 1.7, 1e-12);
  EXPECT_LT(result.rmse, 1e-12);
  EXPECT_LT((result.target_from_source.rigid * truth.rigid.Inverse()).Log().norm(), 1e-11);
}

TEST(AlignPoints, RigidAlignmentKeepsScaleOne) {
  std::mt19937_64 generator = SeededGenerator(8, 0);
  const std::vector<Eigen::Vector3d> source = RandomPoints(20, &generator);
  std::vector<Eigen::Vector3d> target;
  for (const Eigen::Vector3d& p : source) target.push_back(1.1 * p);
  const AlignmentResult result = AlignPoints(source, target, false);
  ASSERT_TRUE(result.success);
  EXPECT_EQ(result.target_from_source.scale, 1);
  EXPECT_GT(result.rmse, 0.05);
}

TEST(AlignPoints, TwoPointsAreNotEnough) {
  const std::vector<Eigen::Vector3d> points = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_FALSE(AlignPoints(points, points, true).success);
}

}  // namespace
}  // namespace prism
