// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "prism/camera/frame_state.h"

namespace prism {

// What all photometric residuals between one host and one target frame share, computed once per
// evaluation (by a ceres::EvaluationCallback) instead of once per point.
struct FramePair {
  struct Geometry {
    Eigen::Matrix3d R;  // target_from_host
    Eigen::Vector3d t;
  };

  Geometry current;
  // Where the geometric factors of the Jacobians are evaluated: equal to `current`, or the first
  // estimates of frames that share the marginalisation prior.
  Geometry linearization;
  bool first_estimate = false;  // linearization differs from current

  Matrix6d adjoint;  // of target_from_host at the linearisation point
  // MinusJacobian of both poses at their current values: lifts tangent to stored doubles.
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift_host;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift_target;

  double gain = 1;  // e^(a_j - a_i)
  double host_b = 0;
  double target_b = 0;

  // `*_first_estimate` may be null: the current state is the linearisation point.
  void Update(const FrameState& host,
              const FrameState& target,
              const FrameState* host_first_estimate = nullptr,
              const FrameState* target_first_estimate = nullptr);
};

}  // namespace prism
