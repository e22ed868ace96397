// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/geometry/se3_manifold.h"

#include <ceres/manifold_test_utils.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "prism/geometry/se3.h"
#include "test/geometry/random_se3.h"

// The matchers of manifold_test_utils.h name Ceres' own types without their namespace.
using namespace ceres;  // NOLINT

namespace prism {
namespace {

TEST(SE3Manifold, KeepsCeresInvariants) {
  const SE3Manifold manifold;
  std::mt19937_64 generator = SeededGenerator(5, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const SE3 x_pose = RandomSE3(&generator);
    const Vector x = Eigen::Map<const Vector>(x_pose.data(), 7);
    const Vector delta = 0.3 * RandomTangent(&generator);
    const SE3 y_pose = SE3::Exp(delta) * x_pose;
    const Vector y = Eigen::Map<const Vector>(y_pose.data(), 7);
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, 1e-9);
  }
}

TEST(SE3Manifold, MinusJacobianIsTheLeftInverseOfPlusJacobian) {
  std::mt19937_64 generator = SeededGenerator(6, 0);
  for (int trial = 0; trial < 20; ++trial) {
    const SE3 T = RandomSE3(&generator);
    EXPECT_LT((MinusJacobian(T) * PlusJacobian(T) - Matrix6d::Identity()).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace prism
