// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "prism/geometry/se3.h"
#include "prism/scene/frame_state.h"
#include "prism/scene/noise_model.h"

namespace prism {

// What all photometric residuals between one host and one target frame share, computed once per
// evaluation (by a ceres::EvaluationCallback) instead of once per point.
struct FramePair {
  // What residuals, or their Jacobians, are evaluated at.
  struct Point {
    RigidMotion target_from_host;
    double gain = 1;  // e^(a_j - a_i)
    double host_b = 0;
  };

  Point current;
  // Where Jacobians are evaluated but for the image gradient: equal to `current`, or the first
  // estimates of frames that share the marginalisation prior.
  Point linearization;
  bool first_estimate = false;  // linearization differs from current

  double target_b = 0;
  Matrix6d adjoint;  // of target_from_host at the linearisation point
  // MinusJacobian of both poses at their current values: lifts tangent to stored doubles.
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift_host;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift_target;

  double inverse_sigma = 1;  // 1 / standard deviation of a residual (NoiseModel), intensities

  // `*_first_estimate` may be null: the current state is the linearisation point.
  void Update(const FrameState& host,
              const FrameState& target,
              const FrameState* host_first_estimate = nullptr,
              const FrameState* target_first_estimate = nullptr);
};

// The pair of two frames as they are, residuals weighted by the noise.
FramePair MakeFramePair(const NoiseModel& noise, const FrameState& host, const FrameState& target);

}  // namespace prism
