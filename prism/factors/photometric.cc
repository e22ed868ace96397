// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/photometric.h"

#include <algorithm>

#include "prism/factors/pattern_kernel.h"

namespace prism {
namespace {

// X = rho x_C,j over the pattern, and its derivative by rho. The hot form of
// R ScaledRay(px, rho) + rho t; prism_check_jacobians covers it.
class PatternRays {
 public:
  PatternRays(const RigidMotion& target_from_host,
              const PlenopticProjection& camera,
              const Eigen::Vector2d& px,
              double rho)
      : rho_(rho), camera_(&camera) {
    const Eigen::Matrix3d& R = target_from_host.R;
    const Eigen::Vector3d& t = target_from_host.t;
    const double pixel = camera.s / camera.f;
    const Eigen::Vector2d m = (px - camera.c) * pixel;
    const double k = 1 - rho * camera.center_z();
    const Eigen::Vector3d lateral = R.col(0) * m.x() + R.col(1) * m.y();
    center_ = k * lateral + R.col(2) + rho * t;
    step_x_ = (k * pixel) * R.col(0);
    step_y_ = (k * pixel) * R.col(1);
    d_center_ = t - camera.center_z() * lateral;
    d_step_x_ = (-camera.center_z() * pixel) * R.col(0);
    d_step_y_ = (-camera.center_z() * pixel) * R.col(1);
  }
  PatternGeometry Geometry() const { return Of(center_, step_x_, step_y_); }
  PatternGeometry Derivative() const { return Of(d_center_, d_step_x_, d_step_y_); }
  // Every pixel before the centre of projection.
  bool AreInFront() const {
    bool in_front = true;
    for (const auto& [dx, dy] : kPattern) {
      in_front &= center_.z() + dx * step_x_.z() + dy * step_y_.z() > rho_ * camera_->center_z();
    }
    return in_front;
  }

 private:
  PatternGeometry Of(const Eigen::Vector3d& center,
                     const Eigen::Vector3d& step_x,
                     const Eigen::Vector3d& step_y) const {
    return {center.data(),
            step_x.data(),
            step_y.data(),
            rho_,
            camera_->center_z(),
            camera_->FocalLengthPx(),
            camera_->c.x(),
            camera_->c.y()};
  }

  double rho_;
  const PlenopticProjection* camera_;
  Eigen::Vector3d center_, step_x_, step_y_;
  Eigen::Vector3d d_center_, d_step_x_, d_step_y_;
};

bool Sample(const PhotometricPatch& patch,
            const FramePair& pair,
            const ImageViewF& target_image,
            const PatternRays& rays,
            PatternSamples* samples) {
  const FramePair::Point& at = pair.current;
  return SamplePattern(rays.Geometry(),
                       {patch.intensity.data(),
                        patch.weight.data(),
                        pair.inverse_sigma,
                        at.gain,
                        at.host_b,
                        pair.target_b},
                       target_image,
                       samples);
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
  PatternRays rays(pair_->current.target_from_host, *camera_, patch_->px, rho);
  PatternSamples samples;
  if (!Sample(*patch_, *pair_, target_image_, rays, &samples)) return set_invalid();
  if (pair_->first_estimate) {
    rays = PatternRays(pair_->linearization.target_from_host, *camera_, patch_->px, rho);
    if (!rays.AreInFront()) return set_invalid();
  }
  std::copy_n(samples.residuals, kPatternSize, residuals);
  if (jacobians == nullptr) return true;

  PatternDerivatives derivatives;
  DifferentiatePattern(rays.Geometry(), rays.Derivative(), samples, &derivatives);
  if (jacobians[2] != nullptr) std::copy_n(derivatives.rho, kPatternSize, jacobians[2]);
  if (jacobians[0] == nullptr && jacobians[1] == nullptr) return true;
  const FramePair::Point& at = pair_->linearization;
  // Over a_i and b_i; those over a_j and b_j are -brightness and -weight.
  double J_a[kPatternSize], J_b[kPatternSize];
  for (int k = 0; k < kPatternSize; ++k) {
    J_a[k] = samples.weight[k] * at.gain * (patch_->intensity[k] - at.host_b);
    J_b[k] = samples.weight[k] * at.gain;
  }
  if (jacobians[0] != nullptr) {
    PatternDerivatives host;
    MovePattern(derivatives, pair_->adjoint.data(), &host);
    LiftPattern(host, pair_->lift_host.data(), J_a, J_b, jacobians[0]);
  }
  if (jacobians[1] != nullptr) {
    for (int k = 0; k < kPatternSize; ++k) {
      J_a[k] = -J_a[k];
      J_b[k] = -samples.weight[k];
    }
    LiftPattern(derivatives, pair_->lift_target.data(), J_a, J_b, jacobians[1]);
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
  const PatternRays rays(pair.current.target_from_host, camera, patch.px, rho);
  PatternSamples samples;
  if (!Sample(patch, pair, target_image, rays, &samples)) return false;
  PatternDerivatives derivatives;
  DifferentiatePattern(rays.Geometry(), rays.Derivative(), samples, &derivatives);
  std::copy_n(samples.residuals, kPatternSize, match->residuals.data());
  std::copy_n(derivatives.rho, kPatternSize, match->J_rho.data());
  return true;
}

}  // namespace prism
