// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/solve.h"

#include <algorithm>
#include <memory>
#include <vector>

#include <ceres/problem.h>
#include <ceres/solver.h>

#include "prism/solver/linearize.h"

namespace prism {
namespace {

class GraphCallback : public ceres::EvaluationCallback {
 public:
  explicit GraphCallback(const FactorGraph* graph) : graph_(graph) {}
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override {
    graph_->PrepareForEvaluation(evaluate_jacobians, new_evaluation_point);
  }

 private:
  const FactorGraph* graph_;
};

ceres::Problem::Options ProblemOptions(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options options;
  options.evaluation_callback = callback;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

// Which blocks of points are eliminated first. No factor may tie two of these (Ceres' Schur
// complement takes them one by one): of points that share a factor one is, the others are solved
// for with the rest.
std::vector<bool> EliminatedFirst(const FactorGraph& graph) {
  std::vector<bool> is_first;
  for (const FactorGraph::Block& block : graph.blocks()) {
    is_first.push_back(block.IsPoint());
  }
  for (const FactorGraph::Factor& factor : graph.factors()) {
    bool has_one = false;
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph.BlocksOf(factor)[k];
      if (!is_first[block]) continue;
      is_first[block] = !has_one;
      has_one = true;
    }
  }
  return is_first;
}

}  // namespace

bool SolveOptions::IsValid(std::string* error) const {
  if (max_iterations >= 1 && threads >= 1 && function_tolerance >= 0) return true;
  *error =
      "the solver needs an iteration and a thread or more, and a function tolerance of 0 or more";
  return false;
}

SolveResult Solve(const SolveOptions& options, FactorGraph* graph) {
  GraphCallback callback(graph);
  ceres::Problem problem(ProblemOptions(&callback));
  const auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const std::vector<FactorGraph::Block>& blocks = graph->blocks();
  // Ceres' interface is not const correct; what it is given here it only reads.
  const auto add_block = [&](int i) {
    const BlockKind& kind = *blocks[i].kind;
    problem.AddParameterBlock(
        graph->values(i), kind.size, const_cast<ceres::Manifold*>(kind.manifold.get()));
    if (blocks[i].is_constant) problem.SetParameterBlockConstant(graph->values(i));
  };
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].IsPoint()) continue;
    add_block(static_cast<int>(i));
    ordering->AddElementToGroup(graph->values(static_cast<int>(i)), 1);
  }
  const std::vector<bool> is_first = EliminatedFirst(*graph);
  std::vector<std::unique_ptr<ceres::CostFunction>> wrapped;
  std::vector<bool> has_factor(blocks.size(), false);
  std::vector<double*> parameters;
  for (const FactorGraph::Factor& factor : graph->factors()) {
    parameters.clear();
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int i = graph->BlocksOf(factor)[k];
      parameters.push_back(graph->values(i));
      if (blocks[i].IsPoint() && !has_factor[i]) {
        add_block(i);
        ordering->AddElementToGroup(graph->values(i), is_first[i] ? 0 : 1);
      }
      has_factor[i] = true;
    }
    auto* cost = const_cast<ceres::CostFunction*>(factor.cost);
    if (NeedsFirstEstimateCost(*graph, factor)) {
      wrapped.push_back(std::make_unique<FirstEstimateCost>(*graph, factor));
      cost = wrapped.back().get();
    }
    problem.AddResidualBlock(cost, const_cast<ceres::LossFunction*>(factor.loss), parameters);
  }

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.threads;
  solver.function_tolerance = options.function_tolerance;
  solver.jacobi_scaling = false;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  SolveResult result;
  result.usable = summary.IsSolutionUsable();
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.iterations = std::max(static_cast<int>(summary.iterations.size()) - 1, 0);
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.message = summary.message;
  graph->PrepareForEvaluation();
  return result;
}

}  // namespace prism
