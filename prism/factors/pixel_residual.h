// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "prism/camera/projection.h"
#include "prism/image/image.h"
#include "prism/image/interpolation.h"
#include "prism/image/patch.h"

namespace prism {

// A pixel of a reference frame on one level of its pyramid.
struct ReferencePixel {
  Eigen::Vector2d m = Eigen::Vector2d::Zero();  // (x'_V - c) s / f_L: the direction of its ray
  double intensity = 0;                         // 0 to 255
  double weight = 0;                            // of its squared residual, DSO's gradient weight
};

// Where a frame stands relative to its reference, with what all pixels need of it at hand.
struct RelativeState {
  RigidMotion target_from_reference;
  double gain = 1;  // e^a: I_target = e^a I_reference + b
  double b = 0;
};

// Photometric residual Eq. (20) of one pixel, brightness relative to the reference:
//   r = I_j[Pi_pl(x_i)] - b - e^a I_i,  intensities 0 to 255.
// The tracker's form of PhotometricCost: one pixel instead of a pattern, no manifold to lift to.
struct PixelResidual {
  double value = 0;
  Eigen::Matrix<double, 8, 1> J_state;  // over [target pose (left); a; b], Eqs. (29), (47), (52)
  double J_rho = 0;                     // Eq. (84)
};

// False if the point is at or inside the focal length, its pixel not a pixel inside the image, or
// the image clipped there.
// Jacobians only if asked for.
inline bool EvaluatePixel(const ReferencePixel& pixel,
                          double rho,
                          const RelativeState& state,
                          const ScaledProjection& projection,
                          double focal_length,
                          const ImageViewF& target_image,
                          bool with_jacobians,
                          PixelResidual* residual) {
  const Eigen::Matrix3d& R = state.target_from_reference.R;
  const Eigen::Vector3d& t = state.target_from_reference.t;
  const double k = 1 - rho * focal_length;
  const Eigen::Vector3d X = R * Eigen::Vector3d(pixel.m.x() * k, pixel.m.y() * k, 1) + rho * t;
  ScaledProjection::Pixel image;
  if (!projection.Project(X, rho, &image)) return false;
  if (!target_image.Contains(image.x, image.y, 1)) return false;
  const InterpolatedValue target = InterpolateBilinear(target_image, image.x, image.y);
  const double expected = state.gain * pixel.intensity + state.b;
  if (IsClipped(target.value, expected)) return false;
  residual->value = target.value - expected;
  if (!with_jacobians) return true;
  const Eigen::Vector3d over_X = ScaledProjection::PullBack(image, X, target.dx, target.dy);
  residual->J_state.head<6>() = ScaledProjection::OverPose(over_X, X, rho);
  residual->J_state[6] = -state.gain * pixel.intensity;
  residual->J_state[7] = -1;
  const Eigen::Vector3d dX_drho =
      t - focal_length * (R.leftCols<2>() * pixel.m);  // pixel held fixed
  residual->J_rho = projection.OverInverseDepth(over_X, dX_drho);
  return true;
}

}  // namespace prism
