// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/solver/factor_graph.h"

namespace prism {

struct SolveOptions {
  int max_iterations = 10;
  double function_tolerance = 1e-4;  // relative fall of the cost below which it has converged
  int threads = 2;                   // of the evaluation; the result does not depend on it

  bool IsValid(std::string* error) const;
};

struct SolveResult {
  bool usable = false;     // Ceres' verdict: the values may be taken
  bool converged = false;  // before `max_iterations` were spent
  int iterations = 0;
  double initial_cost = 0;
  double final_cost = 0;
  std::string message;  // of Ceres, in words
};

// Minimises the cost of all factors over all blocks that are not constant by Levenberg-Marquardt;
// points follow the other blocks (ReducedProblem). The values end up in the graph. Blocks of points
// without a factor stay as they are. Jacobians of blocks that have a first estimate are evaluated
// there. Precondition: a factor ties a block that is neither constant nor a point.
SolveResult Solve(const SolveOptions& options, FactorGraph* graph);

}  // namespace prism
