// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/frame_manifold.h"

#include <ceres/manifold_test_utils.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "prism/scene/frame_state.h"
#include "prism/solver/linear_prior.h"
#include "test/camera/numeric_jacobian.h"
#include "test/geometry/random_se3.h"

using namespace ceres;  // NOLINT: manifold_test_utils.h names Ceres' types without their namespace

namespace prism {
namespace {

TEST(FrameManifold, KeepsCeresInvariants) {
  const FrameManifold manifold;
  std::mt19937_64 generator = SeededGenerator(21, 0);
  for (int trial = 0; trial < 20; ++trial) {
    FrameState x_state(RandomSE3(&generator), 0.1, -3);
    FrameState y_state(SE3::Exp(0.3 * RandomTangent(&generator)) * x_state.pose(), 0.3, 5);
    const Vector x = Eigen::Map<const Vector>(x_state.data(), 9);
    const Vector y = Eigen::Map<const Vector>(y_state.data(), 9);
    Vector delta(8);
    delta << 0.3 * RandomTangent(&generator), 0.2, -1;
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, 1e-9);
  }
}

TEST(LinearPriorCost, IsLinearInTheDifferenceFromItsLinearisationPoint) {
  std::mt19937_64 generator = SeededGenerator(22, 0);
  LinearPrior prior;
  prior.A = Eigen::MatrixXd::Random(10, 16);
  prior.b = Eigen::VectorXd::Random(10);
  const FrameState at[2] = {FrameState(RandomSE3(&generator), 0.1, 1),
                            FrameState(RandomSE3(&generator), -0.2, 2)};
  prior.blocks = {{FrameStateKind(), 0, Eigen::Map<const Eigen::VectorXd>(at[0].data(), 9)},
                  {FrameStateKind(), 1, Eigen::Map<const Eigen::VectorXd>(at[1].data(), 9)}};
  const LinearPriorCost cost(&prior);
  Eigen::VectorXd delta = 0.5 * Eigen::VectorXd::Random(16);
  FrameState x[2];
  for (int i = 0; i < 2; ++i) {
    FrameManifold().Plus(at[i].data(), delta.data() + 8 * i, x[i].data());
  }
  const double* parameters[] = {x[0].data(), x[1].data()};
  Eigen::VectorXd residuals(10);
  ASSERT_TRUE(cost.Evaluate(parameters, residuals.data(), nullptr));
  EXPECT_LT((residuals - (prior.A * delta + prior.b)).norm(), 1e-12);
}

TEST(LinearPriorCost, JacobianIsExactAtTheLinearisationPointAndFirstEstimateElsewhere) {
  std::mt19937_64 generator = SeededGenerator(23, 0);
  LinearPrior prior;
  prior.A = Eigen::MatrixXd::Random(6, 8);
  prior.b = Eigen::VectorXd::Random(6);
  const FrameState at(RandomSE3(&generator), 0.1, 1);
  prior.blocks = {{FrameStateKind(), 0, Eigen::Map<const Eigen::VectorXd>(at.data(), 9)}};
  const LinearPriorCost cost(&prior);
  const auto tangent_jacobian = [&](const FrameState& x) -> Eigen::MatrixXd {
    Eigen::Matrix<double, 6, 9, Eigen::RowMajor> J;
    Eigen::VectorXd residuals(6);
    const double* parameters[] = {x.data()};
    double* jacobians[] = {J.data()};
    EXPECT_TRUE(cost.Evaluate(parameters, residuals.data(), jacobians));
    Eigen::Matrix<double, 9, 8, Eigen::RowMajor> plus;
    FrameManifold().PlusJacobian(x.data(), plus.data());
    return J * plus;
  };
  const auto residuals_at = [&](const Eigen::VectorXd& delta) -> Eigen::VectorXd {
    FrameState x;
    FrameManifold().Plus(at.data(), delta.data(), x.data());
    const double* parameters[] = {x.data()};
    Eigen::VectorXd residuals(6);
    EXPECT_TRUE(cost.Evaluate(parameters, residuals.data(), nullptr));
    return residuals;
  };
  EXPECT_LT((tangent_jacobian(at) - NumericJacobian(residuals_at, Eigen::VectorXd::Zero(8))).norm(),
            1e-8);
  const FrameState moved(SE3::Exp(0.2 * RandomTangent(&generator)) * at.pose(), 0.4, -1);
  EXPECT_LT((tangent_jacobian(moved) - prior.A).norm(), 1e-12);
}

}  // namespace
}  // namespace prism
