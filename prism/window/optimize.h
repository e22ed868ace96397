// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/window/window.h"

namespace prism {

// A posteriori variance factors: mean robustly weighted squared residual over its standard
// deviation. 1 if the stated standard deviation is right; 0 without residuals.
struct VarianceFactors {
  double photometric = 0;
  double depth = 0;
};

struct OptimizationResult {
  bool usable = false;  // Ceres' verdict on the solution
  int iterations = 0;
  int photometric_residuals = 0;  // patterns of 8
  int depth_residuals = 0;
  double initial_cost = 0;
  double final_cost = 0;
  double rms = 0;  // of photometric residuals, intensities 0 to 255, unweighted by gradient
  VarianceFactors variance_factors;
};

// Optimises all states and inverse depths of the window jointly by Levenberg-Marquardt with the
// inverse depths eliminated (Schur complement): photometric residuals of every point in every
// keyframe that observes it, inverse virtual depth residuals, and the prior. Without a prior the
// oldest keyframe is held. The one place where the window's Ceres problem is built.
OptimizationResult OptimizeWindow(const WindowOptions& options, Window* window);

}  // namespace prism
