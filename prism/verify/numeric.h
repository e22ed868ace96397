// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include <Eigen/Core>

#include "prism/verify/jacobian_check.h"

namespace prism {

// Central differences with Richardson extrapolation of residuals over an increment of `dimension`
// numbers, at 0. The step stays inside one pixel of the bilinear interpolant, whose derivative
// jumps at pixel borders.
Eigen::MatrixXd NumericTangentJacobian(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals_at, int dimension);

// Raises `error` to the largest mixed difference of two matrices; a NaN counts as infinite.
void RaiseMixedError(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double* error);

}  // namespace prism
