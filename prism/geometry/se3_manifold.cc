// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/geometry/se3_manifold.h"

#include <algorithm>

#include "prism/geometry/se3.h"

namespace prism {

bool SE3Manifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const SE3 updated = SE3::Exp(Eigen::Map<const Vector6d>(delta)) * SE3(x);
  std::copy_n(updated.data(), 7, x_plus_delta);
  return true;
}

bool SE3Manifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
  J = prism::PlusJacobian(SE3(x));
  return true;
}

bool SE3Manifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  // Normalised, so that the derivative over y has no part along the quaternion itself.
  const SE3 y_pose(Eigen::Quaterniond(y), Eigen::Vector3d(y + 4));
  Eigen::Map<Vector6d> difference(y_minus_x);
  difference = (y_pose * SE3(x).Inverse()).Log();
  return true;
}

bool SE3Manifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
  J = prism::MinusJacobian(SE3(x));
  return true;
}

}  // namespace prism
