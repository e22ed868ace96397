// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/frame_manifold.h"

#include <memory>

#include <Eigen/Core>

#include "prism/geometry/se3.h"
#include "prism/geometry/se3_manifold.h"

namespace prism {

bool FrameManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  x_plus_delta[7] = x[7] + (hold_affine_ ? 0 : delta[6]);
  x_plus_delta[8] = x[8] + (hold_affine_ ? 0 : delta[7]);
  return SE3Manifold().Plus(x, delta, x_plus_delta);
}

bool FrameManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 9, 8, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topLeftCorner<7, 6>() = prism::PlusJacobian(SE3(x));
  if (!hold_affine_) J.bottomRightCorner<2, 2>().setIdentity();
  return true;
}

bool FrameManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  y_minus_x[6] = y[7] - x[7];
  y_minus_x[7] = y[8] - x[8];
  return SE3Manifold().Minus(y, x, y_minus_x);
}

bool FrameManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 8, 9, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topLeftCorner<6, 7>() = prism::MinusJacobian(SE3(x));
  J.bottomRightCorner<2, 2>().setIdentity();
  return true;
}

BlockKindPtr FrameStateKind(bool hold_affine) {
  const auto make = [](bool hold) {
    return std::make_shared<const BlockKind>(BlockKind{"frame state",
                                                       FrameState::kSize,
                                                       BlockLifetime::kKeyframe,
                                                       std::make_shared<FrameManifold>(hold)});
  };
  static const BlockKindPtr free = make(false);
  static const BlockKindPtr held = make(true);
  return hold_affine ? held : free;
}

BlockKindPtr InverseDepthKind() {
  static const BlockKindPtr kind =
      std::make_shared<const BlockKind>(BlockKind{"inverse depth", 1, BlockLifetime::kPoint});
  return kind;
}

}  // namespace prism
