// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/distortion.h"

#include <Eigen/LU>

namespace prism {

Eigen::Vector2d Distortion::Distort(const Eigen::Vector2d& undistorted, Eigen::Matrix2d* J) const {
  const double x = undistorted.x();
  const double y = undistorted.y();
  const double r2 = x * x + y * y;
  const double radial = A0 * r2 + A1 * r2 * r2;
  if (J != nullptr) {
    const double radial_r2 = A0 + 2 * A1 * r2;  // d radial / d r^2
    (*J)(0, 0) = 1 + radial + 2 * x * x * radial_r2 + 6 * B0 * x + 2 * B1 * y;
    (*J)(0, 1) = 2 * x * y * radial_r2 + 2 * B0 * y + 2 * B1 * x;
    (*J)(1, 0) = (*J)(0, 1);
    (*J)(1, 1) = 1 + radial + 2 * y * y * radial_r2 + 6 * B1 * y + 2 * B0 * x;
  }
  return {x + x * radial + B0 * (r2 + 2 * x * x) + 2 * B1 * x * y,
          y + y * radial + B1 * (r2 + 2 * y * y) + 2 * B0 * x * y};
}

Eigen::Vector2d Distortion::Undistort(const Eigen::Vector2d& distorted) const {
  if (IsZero()) return distorted;
  Eigen::Vector2d undistorted = distorted;
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d residual = Distort(undistorted, &J) - distorted;
    undistorted -= J.inverse() * residual;
    if (residual.cwiseAbs().maxCoeff() <= 1e-15 * distorted.cwiseAbs().maxCoeff()) break;
  }
  return undistorted;
}

}  // namespace prism
