// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prism/factors/term.h"
#include "prism/window/options.h"
#include "prism/window/uncertainty.h"

namespace prism {

// How the factors of one term fit after an optimisation.
struct TermSummary {
  std::string name;
  int factors = 0;
  // A posteriori variance factor: mean robustly weighted squared residual over its variance. 1 if
  // the stated standard deviation is right (less for a term that nothing contradicts); 0 without
  // factors.
  double variance_factor = 0;
};

struct OptimizationResult {
  SolveResult solve;
  std::vector<TermSummary> terms;                // in the order of the terms
  std::optional<WindowUncertainty> uncertainty;  // nothing: not solved, or not determined

  // Of the term of a name; 0 if there is none.
  double VarianceFactor(const std::string& term) const;
};

// Optimises all states and inverse depths of the window jointly, with the factors of all terms.
// Without a prior the oldest keyframe is held. If the solution is not usable (solve.usable), the
// window stays as it was. Points get the standard deviations of their inverse depths.
OptimizationResult OptimizeWindow(const WindowOptions& options,
                                  const TermList& terms,
                                  Window* window);

}  // namespace prism
