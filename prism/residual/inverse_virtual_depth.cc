// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/residual/inverse_virtual_depth.h"

#include <glog/logging.h>

namespace prism {

InverseVirtualDepthCost::InverseVirtualDepthCost(double w_measured,
                                                 double sigma,
                                                 const PlenopticProjection* camera)
    : w_measured_(w_measured), inverse_sigma_(1 / sigma), camera_(camera) {
  CHECK_GT(sigma, 0);
}

bool InverseVirtualDepthCost::Evaluate(double const* const* parameters,
                                       double* residuals,
                                       double** jacobians) const {
  const double rho = parameters[0][0];
  const bool valid = rho * camera_->f < 1;
  double dw_drho = 0;
  residuals[0] =
      valid ? (InverseVirtualDepth(*camera_, rho, &dw_drho) - w_measured_) * inverse_sigma_ : 0;
  if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = dw_drho * inverse_sigma_;
  return true;
}

}  // namespace prism
