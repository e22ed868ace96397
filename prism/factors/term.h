// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "prism/factors/window_graph.h"

namespace prism {

// Which factors of a term are outliers, by the RMS of a factor's residuals (|r| / sqrt(number of
// residuals), standard deviations).
struct OutlierRule {
  // Above it a factor is an outlier; infinite: none is.
  double max_rms = INFINITY;
  // If not 0, the limit of each group of factors is (max_rms + quantile_factor * the group's
  // `quantile`) / 2: DSO's frame energy threshold.
  double quantile_factor = 0;
  double quantile = 0.7;
};

// A term of the cost: it says, for a window, which factors there are. Photometry, depth and prior
// are terms like any other; a residual of somebody else's is one more in OdometryOptions::terms
// (docs/add_a_residual.md). Whatever works on factors (solver, marginalisation, outliers, variance
// factors, refinement of a depth, Jacobian check) sees all terms alike.
//
// A term has no state of its own that changes: what is estimated lies in the window. Its costs do
// not fail (ceres::CostFunction::Evaluate returns true): where they are not defined, residuals and
// Jacobians are zero.
class Term {
 public:
  virtual ~Term() = default;

  // Key of its figures in run.json, "inverse virtual depth"; one of its own.
  virtual std::string name() const = 0;

  // Called when a keyframe has come into the window (as its newest): the place to add states, to
  // the window (once, those of the run) or to the keyframe.
  virtual void AddStates(Window* /*window*/) const {}

  // Factors that tie no point: of keyframes, states, or both.
  virtual void AddFactors(const Window& /*window*/, WindowGraph* /*graph*/) const {}

  // Factors of a point hosted by `window.keyframes[host_index]`, whose inverse depth is block
  // `rho_block`. Called once a point, also for a candidate that is not in the window yet.
  virtual void AddPointFactors(const Window& /*window*/,
                               size_t /*host_index*/,
                               const Point& /*point*/,
                               int /*rho_block*/,
                               WindowGraph* /*graph*/) const {}

  virtual OutlierRule outlier_rule() const { return {}; }
  // Notes in the window that a factor of this term is an outlier, so that it is not added again.
  // `point` is the one the factor ties (the last, if there are more), or null.
  virtual void Reject(const FactorGraph::Factor& /*factor*/,
                      Point* /*point*/,
                      Window* /*window*/) const {}
};

// In the order in which they add their factors.
using TermList = std::vector<std::shared_ptr<const Term>>;

// A graph of the window with the factors of all terms: those of points, keyframe by keyframe, then
// the others.
std::unique_ptr<WindowGraph> BuildWindowGraph(const Window& window,
                                              const TermList& terms,
                                              const WindowGraphOptions& options);

}  // namespace prism
