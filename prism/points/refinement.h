// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/factors/term.h"

namespace prism {

// A depth estimate of one point against the other keyframes of the window, their poses held.
struct DepthRefinement {
  bool success = false;
  double rho = 0;           // 1/m
  double rho_variance = 0;  // 1/m^2, of all factors of the point together
  double rms = 0;           // of the factors that tie it to frames, in standard deviations
  int factors = 0;          // of the point; 0: nothing speaks of its depth
  int observations = 0;     // of them, those that tie it to frames
};

struct RefinementOptions {
  int max_iterations = 5;
  double max_rms = 3;               // standard deviations: a worse fit is no match
  double max_relative_sigma = 0.5;  // of rho: a less certain depth is no success

  bool IsValid(std::string* error) const;
};

// Gauss-Newton on the inverse depth of one point after the other, with all factors that the terms
// have for it and everything else held. Made once for many points: it shares the geometry of the
// keyframes, which must not change meanwhile. Window and terms must outlive it.
class DepthRefiner {
 public:
  DepthRefiner(const Window& window, const TermList& terms, const RefinementOptions& options);

  // For a point hosted by window.keyframes[host_index], in the window or not. Fails if no factor
  // speaks of the depth, residuals stay large or the depth uncertain; a point that has a
  // measurement but is seen nowhere else succeeds with the measurement.
  DepthRefinement Refine(size_t host_index, const Point& point);

 private:
  struct NormalEquation;
  NormalEquation Evaluate(double rho);

  const Window& window_;
  const TermList& terms_;
  RefinementOptions options_;
  WindowGraph graph_;
};

}  // namespace prism
