// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/geometry/se3.h"

namespace prism {

// What aligning a frame to a reference finds.
struct AlignmentState {
  SE3 target_from_reference;
  double a = 0;  // relative brightness: I_target = e^a I_reference + b
  double b = 0;
};

// A pose that is known beforehand, by its inverse covariance (tangent on the left).
struct PosePrior {
  SE3 target_from_reference;
  Matrix6d information = Matrix6d::Zero();
};

}  // namespace prism
