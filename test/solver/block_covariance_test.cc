// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/block_covariance.h"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "prism/base/random.h"
#include "test/solver/linear_cost.h"

namespace prism {
namespace {

// Two blocks of 2 and 3, four points, each seen from both blocks.
struct SmallGraph {
  SmallGraph() {
    std::mt19937_64 generator = SeededGenerator(3, 0);
    const auto kind = [](const char* name, int size, BlockLifetime lifetime) {
      return std::make_shared<BlockKind>(BlockKind{name, size, lifetime});
    };
    const double zero[3] = {0, 0, 0};
    graph.AddBlock(kind("a", 2, BlockLifetime::kRun), kRunOwner, zero);
    graph.AddBlock(kind("b", 3, BlockLifetime::kKeyframe), 0, zero);
    for (int i = 0; i < 4; ++i) graph.AddBlock(kind("p", 1, BlockLifetime::kPoint), i, zero);
    for (int point = 2; point < 6; ++point) Add({0, 1, point}, {2, 3, 1}, 3, &generator);
    Add({1}, {3}, 2, &generator);
    graph.PrepareForEvaluation();
  }

  void Add(const std::vector<int>& blocks,
           const std::vector<int>& sizes,
           int rows,
           std::mt19937_64* generator) {
    auto cost = std::make_unique<LinearCost>(rows, sizes, generator);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, 9);
    const int columns[] = {0, 2, 5, 6, 7, 8};
    for (size_t k = 0; k < blocks.size(); ++k) {
      J.middleCols(columns[blocks[k]], sizes[k]) = cost->jacobian(k);
    }
    information += J.transpose() * J;
    FactorGraph::NewFactor factor;
    factor.cost = std::move(cost);
    graph.AddFactor(std::move(factor), blocks);
  }

  FactorGraph graph;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(9, 9);
};

TEST(BlockCovariance, IsTheBlockOfTheWholeInverse) {
  SmallGraph small;
  const auto covariance = EvaluateBlockCovariance(small.graph);
  ASSERT_TRUE(covariance.has_value());
  EXPECT_EQ(covariance->column[0], 0);
  EXPECT_EQ(covariance->column[1], 2);
  EXPECT_EQ(covariance->column[2], -1);
  const Eigen::MatrixXd expected = small.information.inverse().topLeftCorner(5, 5);
  EXPECT_LT((covariance->matrix - expected).norm(), 1e-9 * expected.norm());
}

TEST(BlockCovariance, LeavesOutBlocksThatAreHeld) {
  SmallGraph small;
  small.graph.SetConstant(0);
  const auto covariance = EvaluateBlockCovariance(small.graph);
  ASSERT_TRUE(covariance.has_value());
  EXPECT_EQ(covariance->column[0], -1);
  const Eigen::MatrixXd expected =
      small.information.bottomRightCorner(7, 7).inverse().topLeftCorner(3, 3);
  EXPECT_LT((covariance->matrix - expected).norm(), 1e-9 * expected.norm());
}

TEST(BlockCovariance, IsNothingWhereABlockIsNotDetermined) {
  const double zero = 0;
  FactorGraph graph;
  graph.AddBlock(
      std::make_shared<BlockKind>(BlockKind{"a", 1, BlockLifetime::kRun}), kRunOwner, &zero);
  EXPECT_FALSE(EvaluateBlockCovariance(graph).has_value());
}

}  // namespace
}  // namespace prism
