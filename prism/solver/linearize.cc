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

std::vector<TermFit> EvaluateTermFits(const FactorGraph& graph, int num_terms) {
  std::vector<TermFit> fits(num_terms);
  for (const FactorGraph::Factor& factor : graph.factors()) {
    const FactorValue value = EvaluateFactor(graph, factor);
    if (value.residuals.size() == 0) continue;
    TermFit& fit = fits[factor.term];
    ++fit.factors;
    fit.variance_factor +=
        value.weight * value.residuals.squaredNorm() / static_cast<double>(value.residuals.size());
  }
  for (TermFit& fit : fits) {
    if (fit.factors > 0) fit.variance_factor /= fit.factors;
  }
  return fits;
}

std::vector<double> ScalarInformation(const FactorGraph& graph,
                                      const std::vector<TermFit>& term_fits) {
  std::vector<double> information(graph.blocks().size(), 0);
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  Eigen::VectorXd r, J;
  for (const FactorGraph::Factor& factor : graph.factors()) {
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph.BlocksOf(factor)[k];
      if (graph.blocks()[block].kind->size != 1) continue;
      r.resize(factor.cost->num_residuals());
      J.resize(factor.cost->num_residuals());
      parameters.clear();
      for (int i = 0; i < factor.num_blocks; ++i) {
        parameters.push_back(graph.values(graph.BlocksOf(factor)[i]));
      }
      jacobians.assign(factor.num_blocks, nullptr);
      jacobians[k] = J.data();
      CHECK(factor.cost->Evaluate(parameters.data(), r.data(), jacobians.data()));
      const double s = r.squaredNorm();
      double rho[3] = {s, 1, 0};
      if (factor.loss != nullptr) factor.loss->Evaluate(s, rho);
      information[block] +=
          rho[1] * J.squaredNorm() / std::max(term_fits[factor.term].variance_factor, 1.0);
    }
  }
  return information;
}

}  // namespace prism
