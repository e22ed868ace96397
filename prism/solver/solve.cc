// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/solve.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>
#include <tbb/task_arena.h>
#include <Eigen/Cholesky>

#include "prism/solver/reduced_problem.h"

namespace prism {
namespace {

class GraphCallback : public ceres::EvaluationCallback {
 public:
  explicit GraphCallback(const FactorGraph* graph) : graph_(graph) {}
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override {
    graph_->PrepareForEvaluation(evaluate_jacobians, new_evaluation_point);
    is_new_state_ = new_evaluation_point;
  }
  bool is_new_state() const { return is_new_state_; }

 private:
  const FactorGraph* graph_;
  bool is_new_state_ = true;
};

// A ReducedProblem as Ceres wants it: residuals r and their Jacobian J with |r|^2 / 2 the cost,
// J^T J = H and J^T r = g. J is a square root of H, and one residual more, which depends on
// nothing, takes what the others leave of the cost.
class ReducedCost : public ceres::CostFunction {
 public:
  ReducedCost(const FactorGraph* graph, const GraphCallback* callback, ReducedProblem* problem)
      : graph_(graph), callback_(callback), problem_(problem) {
    set_num_residuals(problem->TangentSize() + 1);
    for (const int block : problem->blocks()) {
      mutable_parameter_block_sizes()->push_back(graph->blocks()[block].kind->size);
    }
  }

  // The values are those of the graph, which Ceres keeps up to date for the callback.
  bool Evaluate(double const* const* /*parameters*/,
                double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r.setZero();
    ReducedProblem::Linearization at;
    const double cost =
        problem_->Evaluate(callback_->is_new_state(), jacobians != nullptr ? &at : nullptr);
    if (!std::isfinite(cost)) return false;
    if (jacobians != nullptr) Factorize(at, &r, jacobians);
    r[r.size() - 1] = std::sqrt(std::max(2 * cost - r.squaredNorm(), 0.0));
    return true;
  }

 private:
  void Factorize(const ReducedProblem::Linearization& at,
                 Eigen::Map<Eigen::VectorXd>* r,
                 double** jacobians) const {
    const Eigen::Index size = at.g.size();
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(at.H);  // H = P^T L D L^T P
    // Directions of which nothing is known have a pivot of about 0.
    const double least = 1e-15 * at.H.diagonal().maxCoeff();
    const Eigen::VectorXd root =
        ldlt.vectorD().unaryExpr([&](double d) { return d > least ? std::sqrt(d) : 0; });
    Eigen::MatrixXd J = Eigen::MatrixXd::Identity(size, size);
    J = ldlt.transpositionsP() * J;
    J = ldlt.matrixU() * J;
    J = root.asDiagonal() * J;
    const Eigen::VectorXd permuted = ldlt.transpositionsP() * at.g;
    r->head(size) = ldlt.matrixL().solve(permuted);
    for (Eigen::Index i = 0; i < size; ++i) (*r)[i] = root[i] > 0 ? (*r)[i] / root[i] : 0;
    Lift(J, jacobians);
  }

  // From the tangent spaces to the stored numbers.
  void Lift(const Eigen::MatrixXd& J, double** jacobians) const {
    Eigen::Index column = 0;
    for (size_t i = 0; i < problem_->blocks().size(); ++i) {
      const int block = problem_->blocks()[i];
      const BlockKind& kind = *graph_->blocks()[block].kind;
      if (jacobians[i] != nullptr) {
        Eigen::Map<BlockKind::RowMajorMatrix> lifted(jacobians[i], num_residuals(), kind.size);
        lifted.topRows(J.rows()) =
            J.middleCols(column, kind.TangentSize()) * kind.MinusJacobian(graph_->values(block));
        lifted.bottomRows(1).setZero();
      }
      column += kind.TangentSize();
    }
  }

  const FactorGraph* graph_;
  const GraphCallback* callback_;
  ReducedProblem* problem_;
};

ceres::Problem::Options ProblemOptions(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options options;
  options.evaluation_callback = callback;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

}  // namespace

bool SolveOptions::IsValid(std::string* error) const {
  if (max_iterations >= 1 && threads >= 1 && function_tolerance >= 0) return true;
  *error =
      "the solver needs an iteration and a thread or more, and a function tolerance of 0 or more";
  return false;
}

SolveResult Solve(const SolveOptions& options, FactorGraph* graph) {
  ReducedProblem reduced(graph, 0.1 * options.function_tolerance);
  GraphCallback callback(graph);
  ReducedCost cost(graph, &callback, &reduced);
  CHECK(!reduced.blocks().empty()) << "nothing but points";
  ceres::Problem problem(ProblemOptions(&callback));
  std::vector<double*> parameters;
  for (const int block : reduced.blocks()) {
    const BlockKind& kind = *graph->blocks()[block].kind;
    parameters.push_back(graph->values(block));
    // Ceres' interface is not const correct; what it is given here it only reads.
    problem.AddParameterBlock(
        parameters.back(), kind.size, const_cast<ceres::Manifold*>(kind.manifold.get()));
  }
  problem.AddResidualBlock(&cost, nullptr, parameters);

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = 1;  // it sees one small dense block
  solver.function_tolerance = options.function_tolerance;
  solver.jacobi_scaling = false;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  tbb::task_arena(options.threads).execute([&] { ceres::Solve(solver, &problem, &summary); });

  SolveResult result;
  result.usable = summary.IsSolutionUsable();
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.iterations = std::max(static_cast<int>(summary.iterations.size()) - 1, 0);
  result.initial_cost = reduced.initial_cost();
  result.final_cost = summary.final_cost;
  result.message = summary.message;
  if (result.usable) reduced.StorePoints();
  graph->PrepareForEvaluation();
  return result;
}

}  // namespace prism
