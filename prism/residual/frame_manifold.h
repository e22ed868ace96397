// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/manifold.h>

namespace prism {

// The manifold of FrameState: SE3Manifold x R^2, 9 doubles with an 8-dimensional tangent space.
// One block a frame instead of two makes the Schur complement cheaper.
class FrameManifold : public ceres::Manifold {
 public:
  // `hold_affine`: brightness does not move (the tangent keeps its size; its last two directions do
  // nothing).
  explicit FrameManifold(bool hold_affine = false) : hold_affine_(hold_affine) {}

  int AmbientSize() const override { return 9; }
  int TangentSize() const override { return 8; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  bool hold_affine_;
};

}  // namespace prism
