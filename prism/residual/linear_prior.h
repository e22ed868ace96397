// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "prism/camera/frame_state.h"

namespace prism {

// What marginalised frames and points still say about the frames that remain:
//   r = A (x [-] x_lin) + b,
// with [-] the difference of FrameManifold (Log of the left increment; affine parts subtracted).
struct LinearPrior {
  Eigen::MatrixXd A;                      // rows x 8 n
  Eigen::VectorXd b;                      // rows
  std::vector<FrameState> linearization;  // x_lin of the n frames, in the order of A's columns

  bool empty() const { return A.rows() == 0; }
};

// Residuals: rows of A. Parameter blocks: n FrameStates (9 each). Jacobian: A at every x (first
// estimate: the prior was linearised once), lifted to the stored doubles at the current state.
// The derivative of [-] away from x_lin, which differs from the identity by O(|x [-] x_lin|), is
// left out on purpose: taking it in would move the null space that A was built with.
// `prior` must outlive the cost.
class LinearPriorCost : public ceres::CostFunction {
 public:
  explicit LinearPriorCost(const LinearPrior* prior);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const LinearPrior* prior_;
};

}  // namespace prism
