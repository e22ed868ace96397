// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/schur_complement.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/LU>

namespace prism {
namespace {

struct Problem {
  Eigen::MatrixXd J;
  Eigen::VectorXd r;
  LinearSystem system;
};

Problem RandomProblem(int rows, int columns, unsigned seed = 1) {
  std::srand(seed);
  Problem problem;
  problem.J = Eigen::MatrixXd::Random(rows, columns);
  problem.r = Eigen::VectorXd::Random(rows);
  problem.system = {problem.J.transpose() * problem.J, problem.J.transpose() * problem.r};
  return problem;
}

// The strict upper triangle, which must not be read, filled with NaN.
LinearSystem WithPoisonedUpperTriangle(LinearSystem system) {
  for (Eigen::Index j = 0; j < system.H.cols(); ++j) {
    for (Eigen::Index i = 0; i < j; ++i) system.H(i, j) = std::numeric_limits<double>::quiet_NaN();
  }
  return system;
}

TEST(Marginalize, EqualsTheInverseOfTheCovarianceBlock) {
  const Problem problem = RandomProblem(30, 12);
  const MarginalizationResult result =
      Marginalize(WithPoisonedUpperTriangle(problem.system), {0, 1, 2, 3, 4});
  const Eigen::MatrixXd covariance = problem.system.H.inverse();
  const Eigen::MatrixXd expected = covariance.bottomRightCorner(7, 7).inverse();
  EXPECT_LT((result.system.H - expected).norm(), 1e-10 * expected.norm());
  EXPECT_EQ(result.marginalized.rank, 5);
}

TEST(Marginalize, OrderOfTheVariablesDoesNotMatter) {
  const Problem problem = RandomProblem(30, 8);
  const MarginalizationResult a = Marginalize(problem.system, {5, 1, 3});
  const MarginalizationResult b = Marginalize(problem.system, {1, 3, 5});
  EXPECT_LT((a.system.H - b.system.H).norm(), 1e-12);
  EXPECT_LT((a.system.b - b.system.b).norm(), 1e-12);
}

TEST(Marginalize, KeepsTheOptimumOfALinearProblem) {
  const Problem problem = RandomProblem(30, 10);
  const Eigen::VectorXd before = -problem.system.H.inverse() * problem.system.b;
  const MarginalizationResult result = Marginalize(problem.system, {2, 4, 9});
  const Eigen::VectorXd after = -result.system.H.inverse() * result.system.b;
  const std::vector<int> kept = {0, 1, 3, 5, 6, 7, 8};
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_NEAR(after(i), before(kept[i]), 1e-11);
}

TEST(Marginalize, SeveralStepsEqualOne) {
  const Problem problem = RandomProblem(40, 9);
  const MarginalizationResult once = Marginalize(problem.system, {0, 1, 2});
  LinearSystem stepwise = problem.system;
  for (int step = 0; step < 3; ++step) stepwise = Marginalize(stepwise, {0}).system;
  EXPECT_LT((once.system.H - stepwise.H).norm(), 1e-11 * once.system.H.norm());
  EXPECT_LT((once.system.b - stepwise.b).norm(), 1e-11);
}

TEST(Marginalize, AVariableWithoutInformationPassesNothingOn) {
  Problem problem = RandomProblem(30, 6);
  problem.J.col(2).setZero();
  problem.system = {problem.J.transpose() * problem.J, problem.J.transpose() * problem.r};
  const MarginalizationResult with = Marginalize(problem.system, {1, 2});
  const MarginalizationResult without = Marginalize(problem.system, {1});
  EXPECT_EQ(with.marginalized.rank, 1);
  EXPECT_TRUE(with.system.H.allFinite());
  EXPECT_NEAR(with.system.H(0, 0), without.system.H(0, 0), 1e-11);
}

TEST(Marginalize, ReportsARankDeficientBlock) {
  Problem problem = RandomProblem(30, 6);
  problem.J.col(1) = 3 * problem.J.col(0);
  problem.system = {problem.J.transpose() * problem.J, problem.J.transpose() * problem.r};
  const MarginalizationResult result = Marginalize(problem.system, {0, 1});
  EXPECT_EQ(result.marginalized.size, 2);
  EXPECT_EQ(result.marginalized.rank, 1);
  EXPECT_LT(
      (result.system.H - Marginalize(problem.system, {0}).system.H.bottomRightCorner(4, 4)).norm(),
      1e-9);
}

TEST(SquareRoot, FactorsTheSystem) {
  const Problem problem = RandomProblem(5, 8);  // rank 5
  const SquareRootSystem root = SquareRoot(WithPoisonedUpperTriangle(problem.system));
  EXPECT_EQ(root.rank.rank, 5);
  EXPECT_EQ(root.A.rows(), 5);
  EXPECT_LT((root.A.transpose() * root.A - problem.system.H).norm(), 1e-11);
  EXPECT_LT((root.A.transpose() * root.r - problem.system.b).norm(), 1e-11);
}

TEST(SquareRoot, CopesWithVeryDifferentUnits) {
  Problem problem = RandomProblem(30, 6);
  problem.J.col(3) *= 1e8;
  problem.system = {problem.J.transpose() * problem.J, problem.J.transpose() * problem.r};
  const SquareRootSystem root = SquareRoot(problem.system);
  EXPECT_EQ(root.rank.rank, 6);
  EXPECT_LT(root.rank.condition, 100);
}

TEST(MarginalizeSquareRoot, EqualsTheSchurComplement) {
  const Problem problem = RandomProblem(40, 9);
  const std::vector<int> marginalized = {7, 0, 3};
  const SquareRootMarginalization root = MarginalizeSquareRoot(problem.J, problem.r, marginalized);
  const MarginalizationResult schur = Marginalize(problem.system, marginalized);
  EXPECT_LT((root.J.transpose() * root.J - schur.system.H).norm(), 1e-11);
  EXPECT_LT((root.J.transpose() * root.r - schur.system.b).norm(), 1e-11);
}

TEST(MarginalizeSquareRoot, StaysAccurateWhereSquaringLosesAllDigits) {
  // Two nearly parallel columns: H_mm has condition 1e18, beyond double precision.
  std::srand(3);
  Eigen::MatrixXd J = Eigen::MatrixXd::Random(20, 4);
  const Eigen::VectorXd direction = Eigen::VectorXd::Random(20);
  J.col(1) = J.col(0) + 1e-9 * direction;
  const Eigen::VectorXd r = Eigen::VectorXd::Random(20);
  const SquareRootMarginalization root = MarginalizeSquareRoot(J, r, {0, 1}, 1e-24);
  // The same column space, written without cancellation.
  Eigen::MatrixXd well = J;
  well.col(1) = direction;
  const SquareRootMarginalization expected = MarginalizeSquareRoot(well, r, {0, 1});
  const Eigen::MatrixXd H = root.J.transpose() * root.J;
  const Eigen::MatrixXd H_expected = expected.J.transpose() * expected.J;
  EXPECT_LT((H - H_expected).norm(), 1e-6 * H_expected.norm());
  EXPECT_EQ(root.marginalized.rank, 2);
}

}  // namespace
}  // namespace prism
