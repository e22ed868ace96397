// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// The solver's functions on small problems of blocks of sizes 1, 2 and 3 that know nothing of
// cameras.
#include "prism/solver/factor_graph.h"

#include <random>

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "prism/solver/linearize.h"
#include "prism/solver/marginalize_blocks.h"
#include "prism/solver/solve.h"
#include "test/solver/linear_cost.h"

namespace prism {
namespace {

BlockKindPtr Kind(const std::string& name, int size, BlockLifetime lifetime) {
  return std::make_shared<BlockKind>(BlockKind{name, size, lifetime});
}

const BlockKindPtr kPoint = Kind("point", 1, BlockLifetime::kPoint);
const BlockKindPtr kKeyframe = Kind("keyframe", 3, BlockLifetime::kKeyframe);
const BlockKindPtr kRun = Kind("offset", 2, BlockLifetime::kRun);

// Keyframes 0, 1, 2, an offset and four points: 0 and 1 of keyframe 0 (and tied to each other), 2
// and 3 of keyframe 1.
void AddBlocks(FactorGraph* graph) {
  const double zero[3] = {0, 0, 0};
  for (int i = 0; i < 3; ++i) graph->AddBlock(kKeyframe, i, zero);
  graph->AddBlock(kRun, 0, zero);
  for (int i = 0; i < 4; ++i) graph->AddBlock(kPoint, i, zero);
}

void AddLinearFactor(int rows,
                     const std::vector<int>& blocks,
                     std::mt19937_64* generator,
                     FactorGraph* graph,
                     bool is_linear = false) {
  std::vector<int> sizes;
  for (const int block : blocks) sizes.push_back(graph->blocks()[block].kind->size);
  FactorGraph::NewFactor factor;
  factor.cost = std::make_unique<LinearCost>(rows, sizes, generator);
  factor.is_linear = is_linear;
  graph->AddFactor(std::move(factor), blocks);
}

SolveOptions Thorough() {
  SolveOptions options;
  options.max_iterations = 50;
  options.function_tolerance = 1e-14;
  options.threads = 1;
  return options;
}

TEST(MarginalizeBlocks, LeavesTheOptimumOfALinearProblemWhereItWas) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937_64 generator = SeededGenerator(seed, 0);
    FactorGraph all;
    AddBlocks(&all);
    // Everything but points 2 and 3, which only stay in the graph to have a factor of their own.
    AddLinearFactor(6, {0, 1, 4}, &generator, &all);
    AddLinearFactor(6, {0, 2, 5}, &generator, &all);
    AddLinearFactor(2, {4, 5}, &generator, &all);
    AddLinearFactor(5, {0, 3}, &generator, &all);
    const BlockMarginalization marginalized = MarginalizeBlocks(all, {0, 4, 5});
    EXPECT_EQ(marginalized.factors, 4);
    EXPECT_EQ(marginalized.prior_blocks, (std::vector<int>{1, 2, 3})) << "seed " << seed;

    // The same further factors in both problems.
    const auto add_rest = [&](FactorGraph* graph) {
      std::mt19937_64 rest = SeededGenerator(seed, 1);
      AddLinearFactor(8, {1, 2, 3, 6}, &rest, graph);
      AddLinearFactor(8, {1, 3, 7}, &rest, graph);
    };
    add_rest(&all);
    Solve(Thorough(), &all);
    FactorGraph reduced;
    AddBlocks(&reduced);
    FactorGraph::NewFactor prior;
    prior.cost = std::make_unique<LinearPriorCost>(&marginalized.prior);
    reduced.AddFactor(std::move(prior), {1, 2, 3});
    add_rest(&reduced);
    Solve(Thorough(), &reduced);
    for (const int block : {1, 2, 3, 6, 7}) {
      for (int i = 0; i < all.blocks()[block].kind->size; ++i) {
        EXPECT_NEAR(all.values(block)[i], reduced.values(block)[i], 1e-7)
            << "seed " << seed << ", block " << block;
      }
    }
  }
}

TEST(MarginalizeBlocks, DropsWhatTiesAStayingPointAndTakesInLinearFactors) {
  std::mt19937_64 generator = SeededGenerator(3, 0);
  FactorGraph graph;
  AddBlocks(&graph);
  AddLinearFactor(4, {0, 1, 4}, &generator, &graph);     // taken: its point leaves
  AddLinearFactor(4, {1, 0, 6}, &generator, &graph);     // dropped: point 2 stays
  AddLinearFactor(4, {1, 2}, &generator, &graph);        // not touched
  AddLinearFactor(4, {2, 3}, &generator, &graph, true);  // linear: taken
  const BlockMarginalization marginalized = MarginalizeBlocks(graph, {0, 4});
  EXPECT_EQ(marginalized.factors, 2);
  EXPECT_EQ(marginalized.prior_blocks, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(marginalized.prior.blocks[2].kind->name, "offset");
  EXPECT_EQ(marginalized.prior.A.cols(), 3 + 3 + 2);
}

TEST(MarginalizeBlocks, WithNothingTiedNothingIsLeft) {
  std::mt19937_64 generator = SeededGenerator(8, 0);
  FactorGraph graph;
  AddBlocks(&graph);
  AddLinearFactor(4, {1, 2}, &generator, &graph);
  // No factor at all ties keyframe 0; one speaks of the offset alone, which then leaves.
  EXPECT_TRUE(MarginalizeBlocks(graph, {0}).prior.empty());
  AddLinearFactor(4, {3}, &generator, &graph);
  const BlockMarginalization alone = MarginalizeBlocks(graph, {3});
  EXPECT_EQ(alone.factors, 1);
  EXPECT_TRUE(alone.prior.empty());
  // A point whose only factor is its own.
  AddLinearFactor(1, {4}, &generator, &graph);
  EXPECT_TRUE(MarginalizeBlocks(graph, {4}).prior.empty());
}

TEST(MarginalizeBlocks, WeighsFactorsAsTheirLossDoes) {
  std::mt19937_64 generator = SeededGenerator(4, 0);
  const ceres::HuberLoss loss(0.01);
  Eigen::MatrixXd information[2];
  for (const bool robust : {false, true}) {
    generator = SeededGenerator(4, 0);
    FactorGraph graph;
    AddBlocks(&graph);
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<LinearCost>(6, std::vector<int>{3, 3}, &generator);
    factor.loss = robust ? &loss : nullptr;
    graph.AddFactor(std::move(factor), {0, 1});
    AddLinearFactor(3, {0}, &generator, &graph);
    const LinearPrior prior = MarginalizeBlocks(graph, {0}).prior;
    information[robust] = prior.A.transpose() * prior.A;
  }
  EXPECT_LT(information[1].trace(), 0.1 * information[0].trace());
}

struct SquareFunctor {
  template <typename T>
  bool operator()(const T* x, const T* y, T* r) const {
    r[0] = x[0] * x[0] * y[0];
    r[1] = y[0] * y[0];
    return true;
  }
};

TEST(FirstEstimateCost, TakesJacobiansThereAndResidualsAtTheValues) {
  const BlockKindPtr number = Kind("number", 1, BlockLifetime::kKeyframe);
  FactorGraph graph;
  const double x = 2, y = 3, x_first = 5;
  graph.AddBlock(number, 0, &x, &x_first);
  graph.AddBlock(number, 1, &y);
  FactorGraph::NewFactor factor;
  factor.cost =
      std::make_unique<ceres::AutoDiffCostFunction<SquareFunctor, 2, 1, 1>>(new SquareFunctor);
  graph.AddFactor(std::move(factor), {0, 1});
  ASSERT_TRUE(NeedsFirstEstimateCost(graph, graph.factors()[0]));
  const LinearizedFactor linearized = LinearizeFactor(graph, graph.factors()[0]);
  EXPECT_EQ(linearized.value.residuals, Eigen::Vector2d(12, 9));
  EXPECT_EQ(linearized.jacobians[0], Eigen::Vector2d(2 * 5 * 3, 0));
  EXPECT_EQ(linearized.jacobians[1], Eigen::Vector2d(25, 6));
}

TEST(MarginalizeBlocks, LinearisesAtFirstEstimatesAndStatesResidualsThere) {
  // One keyframe leaves, one stays with a first estimate away from its value.
  std::mt19937_64 generator = SeededGenerator(6, 0);
  FactorGraph graph;
  const double zero[3] = {0, 0, 0}, value[3] = {0.3, -0.2, 0.1}, first[3] = {1, 2, -1};
  graph.AddBlock(kKeyframe, 0, zero);
  graph.AddBlock(kKeyframe, 1, value, first);
  AddLinearFactor(8, {0, 1}, &generator, &graph);
  const LinearPrior prior = MarginalizeBlocks(graph, {0}).prior;
  ASSERT_EQ(prior.blocks.size(), 1u);
  EXPECT_EQ(prior.blocks[0].linearization, Eigen::Vector3d(1, 2, -1));
  // A linear problem: wherever it is linearised, its optimum is the same.
  FactorGraph direct;
  direct.AddBlock(kKeyframe, 0, zero);
  direct.AddBlock(kKeyframe, 1, zero);
  generator = SeededGenerator(6, 0);
  AddLinearFactor(8, {0, 1}, &generator, &direct);
  Solve(Thorough(), &direct);
  const Eigen::Vector3d optimum =
      Eigen::Map<const Eigen::Vector3d>(direct.values(1)) - prior.blocks[0].linearization;
  EXPECT_LT((prior.A.transpose() * (prior.A * optimum + prior.b)).norm(), 1e-9);
}

TEST(EvaluateFit, IsOneForResidualsOfOneStandardDeviation) {
  std::mt19937_64 generator = SeededGenerator(5, 0);
  FactorGraph graph;
  AddBlocks(&graph);
  graph.BeginTerm(1);
  for (int i = 0; i < 200; ++i) AddLinearFactor(4, {0}, &generator, &graph);
  const std::vector<TermFit> fits = EvaluateFit(graph, 2).terms;
  EXPECT_EQ(fits[0].factors, 0);
  EXPECT_EQ(fits[0].variance_factor, 0);
  EXPECT_EQ(fits[1].factors, 200);
  EXPECT_NEAR(fits[1].variance_factor, 1, 0.15);
}

// r = 2 x + offset.
struct Line {
  double offset;
  template <typename T>
  bool operator()(const T* value, T* r) const {
    r[0] = 2.0 * value[0] + offset;
    return true;
  }
};

TEST(EvaluateFit, StatesTheInformationOfNumbersInTheUnitOfWhatResidualsReallyAre) {
  // Residuals 3 and 1 of one term, derivative 2 each, and one unknown: variance factor 10 / (2 -
  // 1).
  const BlockKindPtr number = Kind("number", 1, BlockLifetime::kPoint);
  FactorGraph graph;
  const double x = 0;
  graph.AddBlock(number, 0, &x);
  for (const double offset : {3.0, 1.0}) {
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<ceres::AutoDiffCostFunction<Line, 1, 1>>(new Line{offset});
    graph.AddFactor(std::move(factor), {0});
  }
  EXPECT_NEAR(EvaluateFit(graph, 1).information[0], (4 + 4) / 10.0, 1e-12);
}

TEST(EvaluateFit, ANumberTakesFromEachTermWhatTheTermTellsOfIt) {
  // One unknown, a residual of 3 with derivative 2 in one term and three of 1 in the other.
  const BlockKindPtr number = Kind("number", 1, BlockLifetime::kPoint);
  FactorGraph graph;
  const double x = 0;
  graph.AddBlock(number, 0, &x);
  const std::vector<std::vector<double>> offsets = {{3}, {1, 1, 1}};
  for (size_t term = 0; term < offsets.size(); ++term) {
    graph.BeginTerm(static_cast<int>(term));
    for (const double offset : offsets[term]) {
      FactorGraph::NewFactor factor;
      factor.cost = std::make_unique<ceres::AutoDiffCostFunction<Line, 1, 1>>(new Line{offset});
      graph.AddFactor(std::move(factor), {0});
    }
  }
  const GraphFit fit = EvaluateFit(graph, 2);
  EXPECT_NEAR(fit.terms[0].variance_factor, 9 / (1 - 0.25), 1e-12);
  EXPECT_NEAR(fit.terms[1].variance_factor, 3 / (3 - 0.75), 1e-12);
}

TEST(FactorGraphDeathTest, BlocksComeBeforeFactorsAndSizesMustFit) {
  std::mt19937_64 generator = SeededGenerator(7, 0);
  FactorGraph graph;
  AddBlocks(&graph);
  EXPECT_DEATH(
      {
        FactorGraph::NewFactor factor;
        factor.cost = std::make_unique<LinearCost>(2, std::vector<int>{2}, &generator);
        graph.AddFactor(std::move(factor), {0});
      },
      "keyframe");
  AddLinearFactor(2, {0}, &generator, &graph);
  const double zero = 0;
  EXPECT_DEATH(graph.AddBlock(kPoint, 9, &zero), "after factors");
}

}  // namespace
}  // namespace prism
