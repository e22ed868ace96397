// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prism/camera/plenoptic_camera.h"
#include "prism/factors/term.h"

namespace prism {

// Largest disagreement of one Jacobian block over all samples. Errors are mixed relative and
// absolute, |a - b| / (1 + max(|a|, |b|)), element by element, in the tangent space.
struct JacobianBlockCheck {
  std::string residual;  // "photometric", "photometric, first estimates", "tracker", "term: NAME"
  std::string block;     // "host pose", "frame state 1", ...
  std::optional<double> autodiff_error;  // none where there is no twin
  double numeric_error = 0;
  double largest_element = 0;  // largest |analytic| seen, to show that the block was not all zero
};

// One element of the Jacobian of x'_V,j over the target pose as the supplement prints it.
struct PrintedElement {
  std::string equation;  // "(66)", "(72)"
  std::string element;   // "row 3, w_x"
  double analytic = 0;
  double printed = 0;
};

struct JacobianCheckOptions {
  int samples = 200;
  unsigned seed = 0;
  double tolerance = 1e-8;          // for autodiff_error
  double numeric_tolerance = 1e-5;  // for numeric_error where there is no autodiff_error
};

struct JacobianCheckResult {
  std::vector<JacobianBlockCheck> blocks;
  std::vector<PrintedElement> printed;  // at the errata's point (0.3, -0.2, 2.5) m
  int valid_samples = 0;                // projections that fell into the image
  bool agrees = false;                  // every block within its tolerance
};

bool Agrees(const JacobianBlockCheck& block, const JacobianCheckOptions& options);

// Compares analytic Jacobians with Ceres' automatic differentiation and with central differences,
// over random poses, brightness, depths and images:
// - the photometric and the depth residual, the photometric one with first estimates, the
//   marginalisation prior, and the tracker's own form of the photometric residual;
// - every factor that the terms have for a random window, numerically: also terms of your own. A
//   term without a factor there (it asks for something random windows lack) is not checked.
JacobianCheckResult CheckJacobians(const PlenopticCamera& camera,
                                   const TermList& terms,
                                   const JacobianCheckOptions& options);

}  // namespace prism
