// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/solver/factor_graph.h"

namespace prism {

// A factor at the values of its graph.
struct FactorValue {
  Eigen::VectorXd residuals;  // as the cost gives them, in standard deviations
  double weight = 1;          // rho'(s) of the loss, s = |residuals|^2
  double cost = 0;            // rho(s) / 2
};

// Precondition: the graph is prepared (FactorGraph::PrepareForEvaluation).
FactorValue EvaluateFactor(const FactorGraph& graph, const FactorGraph::Factor& factor);

struct LinearizedFactor {
  FactorValue value;
  std::vector<Eigen::MatrixXd> jacobians;  // over the tangent space, one a block
};

// Jacobians of blocks that have a first estimate are evaluated there, residuals at the values all
// the same.
LinearizedFactor LinearizeFactor(const FactorGraph& graph, const FactorGraph::Factor& factor);

// The cost with its Jacobians evaluated at the first estimates of blocks that have one (null: at
// the values), lifted to the stored doubles at the values:
//   J(x) = J_cost(x_first) PlusJacobian(x_first) MinusJacobian(x).
// What it is made of must outlive it.
class FirstEstimateCost : public ceres::CostFunction {
 public:
  FirstEstimateCost(const FactorGraph& graph, const FactorGraph::Factor& factor);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const ceres::CostFunction* cost_;
  std::vector<const BlockKind*> kinds_;
  std::vector<const double*> first_estimates_;
};

// True if the Jacobians of the factor have to be evaluated elsewhere than at the values, and its
// cost does not do so itself.
bool NeedsFirstEstimateCost(const FactorGraph& graph, const FactorGraph::Factor& factor);

// How the factors of one term fit: the weighted sum of |residuals|^2 over the term's redundancy,
// the weighted number of its residuals less its share in what the blocks of size 1 took (variance
// components, W. Foerstner 1979). 1 if the stated standard deviations are right; 0 without factors
// or redundancy.
struct TermFit {
  int factors = 0;
  double variance_factor = 0;
};

struct GraphFit {
  std::vector<TermFit> terms;
  // Information (inverse variance) of blocks of size 1 with all others held: the weighted sum of
  // the squared derivatives of their factors, each divided by its term's variance factor where that
  // is above 1 (residuals larger than stated tell less). One number a block; 0 for other blocks.
  std::vector<double> information;
};

// Precondition: the graph is prepared. Terms are numbered up to `num_terms`.
GraphFit EvaluateFit(const FactorGraph& graph, int num_terms);

}  // namespace prism
