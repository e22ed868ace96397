// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/reduced_problem.h"

#include <random>

#include <ceres/loss_function.h>
#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "prism/base/random.h"
#include "prism/solver/linearize.h"
#include "prism/solver/solve.h"
#include "test/solver/linear_cost.h"

namespace prism {
namespace {

constexpr int kKeyframes = 3;
constexpr int kPoints = 200;  // of some chunks

BlockKindPtr Kind(const std::string& name, int size, BlockLifetime lifetime) {
  return std::make_shared<BlockKind>(BlockKind{name, size, lifetime});
}

// Keyframes of 3 numbers, each point tied to two of them and by a factor of its own.
void Fill(const ceres::LossFunction* loss, FactorGraph* graph) {
  const BlockKindPtr keyframe = Kind("keyframe", 3, BlockLifetime::kKeyframe);
  const BlockKindPtr point = Kind("point", 1, BlockLifetime::kPoint);
  const double zero[3] = {0, 0, 0};
  for (int i = 0; i < kKeyframes; ++i) graph->AddBlock(keyframe, i, zero);
  for (int i = 0; i < kPoints; ++i) graph->AddBlock(point, i, zero);
  std::mt19937_64 generator = SeededGenerator(1, 0);
  const auto add = [&](int rows, const std::vector<int>& sizes, const std::vector<int>& blocks) {
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<LinearCost>(rows, sizes, &generator);
    factor.loss = loss;
    graph->AddFactor(std::move(factor), blocks);
  };
  for (int i = 0; i < kPoints; ++i) {
    add(8, {3, 3, 1}, {i % kKeyframes, (i + 1) % kKeyframes, kKeyframes + i});
    add(1, {1}, {kKeyframes + i});
  }
  add(4, {3, 3}, {0, 2});
}

TEST(ReducedProblem, IsTheSchurComplementOfAllFactorsWhereThePointsCostLeast) {
  FactorGraph graph;
  Fill(nullptr, &graph);
  ReducedProblem problem(&graph, 1e-12);
  ReducedProblem::Linearization at;
  const double cost = problem.Evaluate(true, &at);
  problem.StorePoints();

  constexpr int kFrames = 3 * kKeyframes, kAll = kFrames + kPoints;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kAll, kAll);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(kAll);
  double sum = 0;
  for (const FactorGraph::Factor& factor : graph.factors()) {
    const LinearizedFactor linearized = LinearizeFactor(graph, factor);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(factor.cost->num_residuals(), kAll);
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph.BlocksOf(factor)[k];
      J.middleCols(block < kKeyframes ? 3 * block : kFrames + block - kKeyframes,
                   linearized.jacobians[k].cols()) = linearized.jacobians[k];
    }
    H += J.transpose() * J;
    g += J.transpose() * linearized.value.residuals;
    sum += linearized.value.cost;
  }
  EXPECT_NEAR(cost, sum, 1e-9 * sum);
  EXPECT_LT(g.tail(kPoints).norm(), 1e-9);
  const Eigen::MatrixXd coupling = H.topRightCorner(kFrames, kPoints);
  const Eigen::VectorXd inverse = H.diagonal().tail(kPoints).cwiseInverse();
  const Eigen::MatrixXd reduced =
      H.topLeftCorner(kFrames, kFrames) - coupling * inverse.asDiagonal() * coupling.transpose();
  EXPECT_LT((at.H - reduced).norm(), 1e-9 * reduced.norm());
  EXPECT_LT((at.g - g.head(kFrames)).norm(), 1e-9 * g.norm());
}

TEST(Solve, EndsWhereTheCostOfPointsAndFramesHasNoGradient) {
  const ceres::CauchyLoss loss(2);
  FactorGraph graph;
  Fill(&loss, &graph);
  SolveOptions options;
  options.max_iterations = 50;
  options.function_tolerance = 1e-12;
  const SolveResult result = Solve(options, &graph);
  EXPECT_TRUE(result.usable);
  EXPECT_LT(result.final_cost, result.initial_cost);
  std::vector<Eigen::VectorXd> gradient(graph.blocks().size(), Eigen::VectorXd::Zero(3));
  for (const FactorGraph::Factor& factor : graph.factors()) {
    const LinearizedFactor linearized = LinearizeFactor(graph, factor);
    for (int k = 0; k < factor.num_blocks; ++k) {
      const Eigen::VectorXd part = linearized.value.weight * linearized.jacobians[k].transpose() *
                                   linearized.value.residuals;
      gradient[graph.BlocksOf(factor)[k]].head(part.size()) += part;
    }
  }
  for (const Eigen::VectorXd& part : gradient) EXPECT_LT(part.norm(), 1e-3);
}

TEST(Solve, GivesTheSameNumbersForAnyNumberOfThreads) {
  const ceres::CauchyLoss loss(2);
  std::vector<double> values[2];
  for (const int threads : {1, 4}) {
    FactorGraph graph;
    Fill(&loss, &graph);
    SolveOptions options;
    options.threads = threads;
    Solve(options, &graph);
    for (int i = 0; i < kKeyframes + kPoints; ++i) values[threads > 1].push_back(*graph.values(i));
  }
  EXPECT_EQ(values[0], values[1]);
}

}  // namespace
}  // namespace prism
