// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/linearize.h"

#include <algorithm>

#include <glog/logging.h>

namespace prism {
namespace {

using RowMajorMatrix = BlockKind::RowMajorMatrix;

std::vector<const double*> Parameters(const FactorGraph& graph, const FactorGraph::Factor& factor) {
  std::vector<const double*> parameters;
  for (int i = 0; i < factor.num_blocks; ++i) {
    parameters.push_back(graph.values(graph.BlocksOf(factor)[i]));
  }
  return parameters;
}

void Weigh(const ceres::LossFunction* loss, FactorValue* value) {
  const double s = value->residuals.squaredNorm();
  double rho[3] = {s, 1, 0};
  if (loss != nullptr) loss->Evaluate(s, rho);
  value->weight = rho[1];
  value->cost = 0.5 * rho[0];
}

// Ambient Jacobians of a cost, one a block.
std::vector<RowMajorMatrix> EvaluateJacobians(const ceres::CostFunction& cost,
                                              const std::vector<const double*>& parameters,
                                              double* residuals) {
  std::vector<RowMajorMatrix> jacobians;
  std::vector<double*> pointers;
  jacobians.reserve(parameters.size());
  for (const int size : cost.parameter_block_sizes()) {
    jacobians.emplace_back(cost.num_residuals(), size);
    pointers.push_back(jacobians.back().data());
  }
  CHECK(cost.Evaluate(parameters.data(), residuals, pointers.data()));
  return jacobians;
}

}  // namespace

FactorValue EvaluateFactor(const FactorGraph& graph, const FactorGraph::Factor& factor) {
  FactorValue value;
  value.residuals.resize(factor.cost->num_residuals());
  CHECK(factor.cost->Evaluate(Parameters(graph, factor).data(), value.residuals.data(), nullptr));
  Weigh(factor.loss, &value);
  return value;
}

LinearizedFactor LinearizeFactor(const FactorGraph& graph, const FactorGraph::Factor& factor) {
  LinearizedFactor linearized;
  linearized.value.residuals.resize(factor.cost->num_residuals());
  const std::vector<const double*> parameters = Parameters(graph, factor);
  std::vector<RowMajorMatrix> jacobians;
  if (NeedsFirstEstimateCost(graph, factor)) {
    const FirstEstimateCost cost(graph, factor);
    jacobians = EvaluateJacobians(cost, parameters, linearized.value.residuals.data());
  } else {
    jacobians = EvaluateJacobians(*factor.cost, parameters, linearized.value.residuals.data());
  }
  Weigh(factor.loss, &linearized.value);
  for (int i = 0; i < factor.num_blocks; ++i) {
    const BlockKind& kind = *graph.blocks()[graph.BlocksOf(factor)[i]].kind;
    linearized.jacobians.push_back(jacobians[i] * kind.PlusJacobian(parameters[i]));
  }
  return linearized;
}

FirstEstimateCost::FirstEstimateCost(const FactorGraph& graph, const FactorGraph::Factor& factor)
    : cost_(factor.cost) {
  set_num_residuals(factor.cost->num_residuals());
  *mutable_parameter_block_sizes() = factor.cost->parameter_block_sizes();
  for (int i = 0; i < factor.num_blocks; ++i) {
    const FactorGraph::Block& block = graph.blocks()[graph.BlocksOf(factor)[i]];
    kinds_.push_back(block.kind.get());
    first_estimates_.push_back(block.first_estimate);
  }
}

bool FirstEstimateCost::Evaluate(double const* const* parameters,
                                 double* residuals,
                                 double** jacobians) const {
  if (!cost_->Evaluate(parameters, residuals, nullptr)) return false;
  if (jacobians == nullptr) return true;
  std::vector<const double*> at(parameters, parameters + kinds_.size());
  for (size_t i = 0; i < kinds_.size(); ++i) {
    if (first_estimates_[i] != nullptr) at[i] = first_estimates_[i];
  }
  Eigen::VectorXd residuals_there(num_residuals());
  const std::vector<RowMajorMatrix> J = EvaluateJacobians(*cost_, at, residuals_there.data());
  for (size_t i = 0; i < kinds_.size(); ++i) {
    if (jacobians[i] == nullptr) continue;
    Eigen::Map<RowMajorMatrix> lifted(jacobians[i], num_residuals(), parameter_block_sizes()[i]);
    if (first_estimates_[i] == nullptr) {
      lifted = J[i];
    } else {
      lifted = J[i] * kinds_[i]->PlusJacobian(at[i]) * kinds_[i]->MinusJacobian(parameters[i]);
    }
  }
  return true;
}

bool NeedsFirstEstimateCost(const FactorGraph& graph, const FactorGraph::Factor& factor) {
  if (factor.keeps_first_estimates) return false;
  for (int i = 0; i < factor.num_blocks; ++i) {
    if (graph.blocks()[graph.BlocksOf(factor)[i]].first_estimate != nullptr) return true;
  }
  return false;
}

GraphFit EvaluateFit(const FactorGraph& graph, int num_terms) {
  GraphFit fit;
  fit.terms.resize(num_terms);
  std::vector<double> redundancy(num_terms, 0);
  const size_t num_blocks = graph.blocks().size();
  std::vector<std::vector<double>> information(num_terms, std::vector<double>(num_blocks, 0));
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  Eigen::VectorXd r;
  Eigen::MatrixXd J;  // a column for each block of size 1
  for (const FactorGraph::Factor& factor : graph.factors()) {
    const Eigen::Index rows = factor.cost->num_residuals();
    if (rows == 0) continue;
    r.resize(rows);
    J.resize(rows, factor.num_blocks);
    parameters.clear();
    jacobians.clear();
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph.BlocksOf(factor)[k];
      parameters.push_back(graph.values(block));
      jacobians.push_back(graph.blocks()[block].kind->size == 1 ? J.col(k).data() : nullptr);
    }
    CHECK(factor.cost->Evaluate(parameters.data(), r.data(), jacobians.data()));
    const double s = r.squaredNorm();
    double rho[3] = {s, 1, 0};
    if (factor.loss != nullptr) factor.loss->Evaluate(s, rho);
    TermFit& term = fit.terms[factor.term];
    ++term.factors;
    term.variance_factor += rho[1] * s;
    redundancy[factor.term] += rho[1] * static_cast<double>(rows);
    for (int k = 0; k < factor.num_blocks; ++k) {
      if (jacobians[k] == nullptr) continue;
      information[factor.term][graph.BlocksOf(factor)[k]] += rho[1] * J.col(k).squaredNorm();
    }
  }
  // A block of size 1 takes as much from the residuals of a term as the term tells of it.
  for (size_t i = 0; i < num_blocks; ++i) {
    double total = 0;
    for (int term = 0; term < num_terms; ++term) total += information[term][i];
    if (!(total > 0)) continue;
    for (int term = 0; term < num_terms; ++term) redundancy[term] -= information[term][i] / total;
  }
  fit.information.assign(num_blocks, 0);
  for (int term = 0; term < num_terms; ++term) {
    TermFit& term_fit = fit.terms[term];
    if (term_fit.factors == 0) continue;
    term_fit.variance_factor =
        redundancy[term] > 0 ? term_fit.variance_factor / redundancy[term] : 0;
    const double factor = std::max(term_fit.variance_factor, 1.0);
    for (size_t i = 0; i < num_blocks; ++i) fit.information[i] += information[term][i] / factor;
  }
  return fit;
}

}  // namespace prism
