// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/residual/linear_prior.h"

#include <glog/logging.h>

#include "prism/residual/frame_manifold.h"

namespace prism {

LinearPriorCost::LinearPriorCost(const LinearPrior* prior) : prior_(prior) {
  CHECK_EQ(prior->A.cols(),
           FrameState::kTangentSize * static_cast<Eigen::Index>(prior->linearization.size()));
  CHECK_EQ(prior->A.rows(), prior->b.size());
  set_num_residuals(static_cast<int>(prior->A.rows()));
  mutable_parameter_block_sizes()->assign(prior->linearization.size(), FrameState::kSize);
}

bool LinearPriorCost::Evaluate(double const* const* parameters,
                               double* residuals,
                               double** jacobians) const {
  constexpr int kTangent = FrameState::kTangentSize;
  const FrameManifold manifold;
  const size_t num_frames = prior_->linearization.size();
  Eigen::VectorXd difference(prior_->A.cols());
  for (size_t i = 0; i < num_frames; ++i) {
    manifold.Minus(
        parameters[i], prior_->linearization[i].data(), difference.data() + kTangent * i);
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = prior_->A * difference + prior_->b;
  if (jacobians == nullptr) return true;

  using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (size_t i = 0; i < num_frames; ++i) {
    if (jacobians[i] == nullptr) continue;
    Eigen::Matrix<double, kTangent, FrameState::kSize, Eigen::RowMajor> lift;
    manifold.MinusJacobian(parameters[i], lift.data());
    Eigen::Map<RowMajorMatrix>(jacobians[i], num_residuals(), FrameState::kSize) =
        prior_->A.middleCols<kTangent>(static_cast<Eigen::Index>(kTangent * i)) * lift;
  }
  return true;
}

}  // namespace prism
