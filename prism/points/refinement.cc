// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/refinement.h"

#include <algorithm>
#include <cmath>

namespace prism {

// Of the one unknown.
struct DepthRefiner::NormalEquation {
  double H = 0;
  double g = 0;
  double energy = 0;        // twice the cost
  double squared_ties = 0;  // weighted squared residuals of factors that tie the point to frames
  int tie_residuals = 0;    // their number
  int observations = 0;     // factors they belong to
};

bool RefinementOptions::IsValid(std::string* error) const {
  if (max_iterations >= 1 && max_rms > 0 && max_relative_sigma > 0) return true;
  *error = "refinement of depths needs an iteration or more, a positive RMS and relative sigma";
  return false;
}

DepthRefiner::DepthRefiner(const Window& window,
                           const TermList& terms,
                           const RefinementOptions& options)
    : window_(window),
      terms_(terms),
      options_(options),
      graph_(window, /*rho=*/1, {/*first_estimates=*/false, /*affine_brightness=*/true}) {}

DepthRefiner::NormalEquation DepthRefiner::Evaluate(double rho) {
  const int rho_block = graph_.FirstPointBlock();
  *graph_.values(rho_block) = rho;
  NormalEquation equation;
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  Eigen::VectorXd r, J;
  for (const FactorGraph::Factor& factor : graph_.factors()) {
    parameters.clear();
    jacobians.clear();
    r.resize(factor.cost->num_residuals());
    J.resize(factor.cost->num_residuals());
    J.setZero();
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph_.BlocksOf(factor)[k];
      parameters.push_back(graph_.values(block));
      jacobians.push_back(block == rho_block ? J.data() : nullptr);
    }
    const bool is_defined = factor.cost->Evaluate(parameters.data(), r.data(), jacobians.data());
    if (!is_defined || J.squaredNorm() == 0) continue;
    const double s = r.squaredNorm();
    double loss[3] = {s, 1, 0};
    if (factor.loss != nullptr) factor.loss->Evaluate(s, loss);
    equation.H += loss[1] * J.squaredNorm();
    equation.g += loss[1] * J.dot(r);
    equation.energy += loss[0];
    if (!graph_.TiesFrame(factor)) continue;
    equation.squared_ties += loss[1] * s;
    equation.tie_residuals += static_cast<int>(r.size());
    ++equation.observations;
  }
  return equation;
}

DepthRefinement DepthRefiner::Refine(size_t host_index, const Point& point) {
  graph_.ClearFactors();
  *graph_.values(graph_.FirstPointBlock()) = point.rho;
  for (size_t term = 0; term < terms_.size(); ++term) {
    graph_.BeginTerm(static_cast<int>(term));
    terms_[term]->AddPointFactors(window_, host_index, point, graph_.FirstPointBlock(), &graph_);
  }

  DepthRefinement result;
  result.factors = static_cast<int>(graph_.factors().size());
  double rho = point.rho;
  NormalEquation equation = Evaluate(rho);
  double damping = 1;
  for (int iteration = 0; iteration < options_.max_iterations && equation.H > 0; ++iteration) {
    const double candidate = std::max(rho - damping * equation.g / equation.H, 1e-4);
    const NormalEquation next = Evaluate(candidate);
    if (next.energy < equation.energy && next.observations >= equation.observations) {
      const double gain = 1 - next.energy / equation.energy;
      rho = candidate;
      equation = next;
      if (gain < 1e-3) break;
    } else {
      damping *= 0.3;
    }
  }
  if (!(equation.H > 0)) return result;
  result.rho = rho;
  result.rho_variance = 1 / equation.H;
  result.observations = equation.observations;
  if (equation.tie_residuals > 0) {
    result.rms = std::sqrt(equation.squared_ties / equation.tie_residuals);
  }
  result.success = result.rms <= options_.max_rms &&
                   std::sqrt(result.rho_variance) <= options_.max_relative_sigma * result.rho;
  return result;
}

}  // namespace prism
