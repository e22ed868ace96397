// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/photometric.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "prism/image/interpolation.h"

namespace prism {
namespace {

using Vector8d = Eigen::Matrix<double, kPatternSize, 1>;
using Matrix86d = Eigen::Matrix<double, kPatternSize, 6, Eigen::RowMajor>;
using FrameJacobian = Eigen::Matrix<double, kPatternSize, FrameState::kSize, Eigen::RowMajor>;

// X = rho x_C,j over the pattern, affine in the pixel: X(dx, dy) = center + dx step_x + dy step_y.
// The hot form of R ScaledRay(px, rho) + rho t; prism_check_jacobians covers it.
struct PatternRays {
  Eigen::Vector3d center, step_x, step_y;
  // d center / d rho and the part of it that each pixel of the pattern adds.
  Eigen::Vector3d d_center, d_step_x, d_step_y;

  PatternRays(const RigidMotion& target_from_host,
              const PlenopticProjection& camera,
              const Eigen::Vector2d& px,
              double rho) {
    const Eigen::Matrix3d& R = target_from_host.R;
    const Eigen::Vector3d& t = target_from_host.t;
    const double pixel = camera.s / camera.f;
    const Eigen::Vector2d m = (px - camera.c) * pixel;
    const double k = 1 - rho * camera.f;
    const Eigen::Vector3d lateral = R.col(0) * m.x() + R.col(1) * m.y();
    center = k * lateral + R.col(2) + rho * t;
    step_x = (k * pixel) * R.col(0);
    step_y = (k * pixel) * R.col(1);
    d_center = t - camera.f * lateral;
    d_step_x = (-camera.f * pixel) * R.col(0);
    d_step_y = (-camera.f * pixel) * R.col(1);
  }
  Eigen::Vector3d At(int k) const {
    return center + kPattern[k][0] * step_x + kPattern[k][1] * step_y;
  }
  // Every pixel beyond the focal length.
  bool AreInFront(double rho_f) const {
    bool in_front = true;
    for (int k = 0; k < kPatternSize; ++k) {
      in_front &= center.z() + kPattern[k][0] * step_x.z() + kPattern[k][1] * step_y.z() > rho_f;
    }
    return in_front;
  }
  Eigen::Vector3d DerivativeAt(int k) const {
    return d_center + kPattern[k][0] * d_step_x + kPattern[k][1] * d_step_y;
  }
};

// A pattern in the target frame.
struct PatternImage {
  std::array<Eigen::Vector3d, kPatternSize> X;
  Vector8d weight;                  // of each residual over its standard deviation
  Vector8d gradient_x, gradient_y;  // Eq. (29), weighted
  Vector8d brightness;              // weight e^(a_j - a_i) (I_i - b_i)
  Vector8d residuals;
};

bool EvaluateResiduals(const PhotometricPatch& patch,
                       const FramePair& pair,
                       const ImageViewF& target_image,
                       const ScaledProjection& projection,
                       const PatternRays& rays,
                       double rho,
                       PatternImage* image) {
  const FramePair::Point& at = pair.current;
  for (int k = 0; k < kPatternSize; ++k) {
    image->X[k] = rays.At(k);
    ScaledProjection::Pixel pixel;
    if (!projection.Project(image->X[k], rho, &pixel)) return false;
    if (!target_image.Contains(pixel.x, pixel.y)) return false;
    const InterpolatedValue sample = InterpolateBilinear(target_image, pixel.x, pixel.y);
    const double weight = patch.weight[k] * pair.inverse_sigma;
    image->weight[k] = weight;
    image->brightness[k] = weight * at.gain * (patch.intensity[k] - at.host_b);
    image->residuals[k] = weight * (sample.value - pair.target_b) - image->brightness[k];
    image->gradient_x[k] = weight * sample.dx;
    image->gradient_y[k] = weight * sample.dy;
  }
  return true;
}

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
  const auto set_invalid = [&] {
    std::fill_n(residuals, kPatternSize, 0.0);
    for (int i = 0; i < 3; ++i) {
      if (jacobians == nullptr || jacobians[i] == nullptr) continue;
      std::fill_n(jacobians[i], kPatternSize * parameter_block_sizes()[i], 0.0);
    }
    return true;
  };
  const double rho = parameters[2][0];
  if (!(rho * camera_->f < 1)) return set_invalid();
  const ScaledProjection projection(*camera_);
  PatternRays rays(pair_->current.target_from_host, *camera_, patch_->px, rho);
  PatternImage image;
  if (!EvaluateResiduals(*patch_, *pair_, target_image_, projection, rays, rho, &image)) {
    return set_invalid();
  }
  if (pair_->first_estimate) {
    rays = PatternRays(pair_->linearization.target_from_host, *camera_, patch_->px, rho);
    if (!rays.AreInFront(rho * camera_->f)) return set_invalid();
  }
  std::copy_n(image.residuals.data(), kPatternSize, residuals);
  if (jacobians == nullptr) return true;
  if (pair_->first_estimate) {
    for (int k = 0; k < kPatternSize; ++k) image.X[k] = rays.At(k);
  }

  const bool with_frames = jacobians[0] != nullptr || jacobians[1] != nullptr;
  Matrix86d J_target;
  Vector8d J_rho;
  for (int k = 0; k < kPatternSize; ++k) {
    const Eigen::Vector3d over_X = ScaledProjection::PullBack(
        projection.At(image.X[k], rho), image.X[k], image.gradient_x[k], image.gradient_y[k]);
    if (with_frames) {
      J_target.row(k) = ScaledProjection::OverPose(over_X, image.X[k], rho).transpose();
    }
    J_rho[k] = projection.OverInverseDepth(over_X, rays.DerivativeAt(k));
  }
  if (jacobians[2] != nullptr) std::copy_n(J_rho.data(), kPatternSize, jacobians[2]);
  if (!with_frames) return true;
  const FramePair::Point& at = pair_->linearization;
  // weight e^(a_j - a_i) (I_i - b_i)
  Vector8d brightness = image.brightness;
  if (pair_->first_estimate) {
    for (int k = 0; k < kPatternSize; ++k) {
      brightness[k] = image.weight[k] * at.gain * (patch_->intensity[k] - at.host_b);
    }
  }
  if (jacobians[0] != nullptr) {
    LiftFrameJacobian(-J_target * pair_->adjoint,
                      pair_->lift_host,
                      brightness,
                      at.gain * image.weight,
                      jacobians[0]);
  }
  if (jacobians[1] != nullptr) {
    LiftFrameJacobian(J_target, pair_->lift_target, -brightness, -image.weight, jacobians[1]);
  }
  return true;
}

bool EvaluatePattern(const PhotometricPatch& patch,
                     const FramePair& pair,
                     const ImageViewF& target_image,
                     const PlenopticProjection& camera,
                     double rho,
                     PatternMatch* match) {
  if (!(rho * camera.f < 1)) return false;
  const ScaledProjection projection(camera);
  const PatternRays rays(pair.current.target_from_host, camera, patch.px, rho);
  PatternImage image;
  if (!EvaluateResiduals(patch, pair, target_image, projection, rays, rho, &image)) return false;
  match->residuals = image.residuals;
  for (int k = 0; k < kPatternSize; ++k) {
    const Eigen::Vector3d over_X = ScaledProjection::PullBack(
        projection.At(image.X[k], rho), image.X[k], image.gradient_x[k], image.gradient_y[k]);
    match->J_rho[k] = projection.OverInverseDepth(over_X, rays.DerivativeAt(k));
  }
  return true;
}

}  // namespace prism
