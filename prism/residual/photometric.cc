// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/residual/photometric.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "prism/image/interpolation.h"

namespace prism {
namespace {

using Vector8d = Eigen::Matrix<double, kPatternSize, 1>;
using Matrix86d = Eigen::Matrix<double, kPatternSize, 6, Eigen::RowMajor>;
using FrameJacobian = Eigen::Matrix<double, kPatternSize, FrameState::kSize, Eigen::RowMajor>;

// X = rho x_C,j over the pattern, affine in the pixel: X(dx, dy) = center + dx step_x + dy step_y
// (Eqs. (15), (17) times rho; see ProjectBetweenFrames).
struct PatternRays {
  Eigen::Vector3d center, step_x, step_y;
  // d center / d rho and the part of it that each pixel of the pattern adds.
  Eigen::Vector3d d_center, d_step_x, d_step_y;

  PatternRays(const FramePair::Geometry& g,
              const PlenopticProjection& camera,
              const Eigen::Vector2d& px,
              double rho) {
    const double pixel = camera.s / camera.f;
    const Eigen::Vector2d m = (px - camera.c) * pixel;
    const double k = 1 - rho * camera.f;
    const Eigen::Vector3d lateral = g.R.col(0) * m.x() + g.R.col(1) * m.y();
    center = k * lateral + g.R.col(2) + rho * g.t;
    step_x = (k * pixel) * g.R.col(0);
    step_y = (k * pixel) * g.R.col(1);
    d_center = g.t - camera.f * lateral;
    d_step_x = (-camera.f * pixel) * g.R.col(0);
    d_step_y = (-camera.f * pixel) * g.R.col(1);
  }
  Eigen::Vector3d At(int k) const {
    return center + kPattern[k][0] * step_x + kPattern[k][1] * step_y;
  }
  Eigen::Vector3d DerivativeAt(int k) const {
    return d_center + kPattern[k][0] * d_step_x + kPattern[k][1] * d_step_y;
  }
};

// J_ambient = [J_pose * lift, J_affine].
void LiftFrameJacobian(const Matrix86d& J_pose,
                       const Eigen::Matrix<double, 6, 7, Eigen::RowMajor>& lift,
                       const Vector8d& J_a,
                       const Vector8d& J_b,
                       double* jacobian) {
  Eigen::Map<FrameJacobian> J(jacobian);
  // lift = [L, I; M, 0]
  J.leftCols<4>().noalias() = J_pose.leftCols<3>() * lift.topLeftCorner<3, 4>();
  J.leftCols<4>().noalias() += J_pose.rightCols<3>() * lift.bottomLeftCorner<3, 4>();
  J.middleCols<3>(4) = J_pose.leftCols<3>();
  J.col(7) = J_a;
  J.col(8) = J_b;
}

}  // namespace

PhotometricCost::PhotometricCost(const PhotometricPatch* patch,
                                 const FramePair* pair,
                                 const ImageViewF& target_image,
                                 const PlenopticProjection* camera)
    : patch_(patch), pair_(pair), target_image_(target_image), camera_(camera) {
  set_num_residuals(kPatternSize);
  *mutable_parameter_block_sizes() = {FrameState::kSize, FrameState::kSize, 1};
}

bool PhotometricCost::Evaluate(double const* const* parameters,
                               double* residuals,
                               double** jacobians) const {
  Eigen::Map<Vector8d> r(residuals);
  const auto set_invalid = [&] {
    r.setZero();
    if (jacobians == nullptr) return true;
    for (int i = 0; i < 3; ++i) {
      if (jacobians[i] != nullptr) {
        std::fill_n(jacobians[i], kPatternSize * parameter_block_sizes()[i], 0.0);
      }
    }
    return true;
  };

  const double rho = parameters[2][0];
  const double f = camera_->f;
  if (!(rho * f < 1)) return set_invalid();
  PatternRays rays(pair_->current, *camera_, patch_->px, rho);
  const double focal_length_px = camera_->FocalLengthPx();

  std::array<Eigen::Vector3d, kPatternSize> X;
  Vector8d gradient_x, gradient_y;  // Eq. (29), weighted
  Vector8d brightness;              // weight e^(a_j - a_i) (I_i - b_i)
  for (int k = 0; k < kPatternSize; ++k) {
    X[k] = rays.At(k);
    const double D = X[k].z() - rho * f;
    if (!(D > 0)) return set_invalid();
    const double alpha = focal_length_px / D;
    const double u = alpha * X[k].x() + camera_->c.x();
    const double v = alpha * X[k].y() + camera_->c.y();
    if (!target_image_.Contains(u, v)) return set_invalid();
    const InterpolatedValue sample = InterpolateBilinear(target_image_, u, v);
    const double weight = patch_->weight[k];
    brightness[k] = weight * pair_->gain * (patch_->intensity[k] - pair_->host_b);
    r[k] = weight * (sample.value - pair_->target_b) - brightness[k];
    gradient_x[k] = weight * sample.dx;
    gradient_y[k] = weight * sample.dy;
  }
  if (jacobians == nullptr) return true;

  Matrix86d J_target;
  Vector8d J_rho;
  if (pair_->first_estimate) {
    rays = PatternRays(pair_->linearization, *camera_, patch_->px, rho);
    for (int k = 0; k < kPatternSize; ++k) X[k] = rays.At(k);
  }
  for (int k = 0; k < kPatternSize; ++k) {
    const double D = X[k].z() - rho * f;
    const double alpha = focal_length_px / D;
    // dr / dX: image gradient times Eq. (47), with X in place of x_C,j.
    const double gx = gradient_x[k] * alpha;
    const double gy = gradient_y[k] * alpha;
    const double gz = -(gx * X[k].x() + gy * X[k].y()) / D;
    // Eq. (52): translation moves X by rho delta_t, rotation by delta_w x X.
    J_target.row(k) << rho * gx, rho * gy, rho * gz,  //
        X[k].y() * gz - X[k].z() * gy, X[k].z() * gx - X[k].x() * gz, X[k].x() * gy - X[k].y() * gx;
    const Eigen::Vector3d dX = rays.DerivativeAt(k);
    J_rho[k] = gx * dX.x() + gy * dX.y() + gz * (dX.z() - f);  // Eq. (84)
  }
  if (jacobians[0] != nullptr) {
    const Matrix86d J_host = -J_target * pair_->adjoint;
    const Vector8d weight =
        Eigen::Map<const Eigen::Matrix<float, kPatternSize, 1>>(patch_->weight.data())
            .cast<double>();
    LiftFrameJacobian(J_host, pair_->lift_host, brightness, pair_->gain * weight, jacobians[0]);
  }
  if (jacobians[1] != nullptr) {
    const Vector8d weight =
        Eigen::Map<const Eigen::Matrix<float, kPatternSize, 1>>(patch_->weight.data())
            .cast<double>();
    LiftFrameJacobian(J_target, pair_->lift_target, -brightness, -weight, jacobians[1]);
  }
  if (jacobians[2] != nullptr) std::copy_n(J_rho.data(), kPatternSize, jacobians[2]);
  return true;
}

}  // namespace prism
