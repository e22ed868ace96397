// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/manifold.h>

#include "prism/scene/frame_state.h"
#include "prism/solver/block.h"

namespace prism {

// The manifold of FrameState: SE3Manifold x R^2, 9 doubles with an 8-dimensional tangent space.
// One block a frame instead of two makes the Schur complement cheaper.
class FrameManifold : public ceres::Manifold {
 public:
  // `hold_affine`: brightness does not move (the tangent keeps its size; its last two directions do
  // nothing).
  explicit FrameManifold(bool hold_affine = false) : hold_affine_(hold_affine) {}

  int AmbientSize() const override { return FrameState::kSize; }
  int TangentSize() const override { return FrameState::kTangentSize; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  bool hold_affine_;
};

// The kinds of the two blocks every window has: "frame state" (FrameState, owner: keyframe id) and
// "inverse depth" (rho in 1/m, owner: number of the point in its graph).
BlockKindPtr FrameStateKind(bool hold_affine = false);
BlockKindPtr InverseDepthKind();

}  // namespace prism
