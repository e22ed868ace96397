// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/inverse_virtual_depth_term.h"

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

bool InverseVirtualDepthTermOptions::IsValid(std::string* error) const {
  if (huber >= 0 && max_residual > 0) return true;
  *error = "the depth term needs a Huber threshold of 0 or more and a positive outlier threshold";
  return false;
}

InverseVirtualDepthTerm::InverseVirtualDepthTerm(const InverseVirtualDepthTermOptions& options)
    : options_(options) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  if (options.huber > 0) loss_ = std::make_unique<ceres::HuberLoss>(options.huber);
}

void InverseVirtualDepthTerm::AddPointFactors(const Window& window,
                                              size_t /*host_index*/,
                                              const Point& point,
                                              int rho_block,
                                              WindowGraph* graph) const {
  if (!(point.w_sigma > 0)) return;
  FactorGraph::NewFactor factor;
  factor.cost = std::make_unique<InverseVirtualDepthCost>(
      point.w_measured, window.noise.DepthScale() * point.w_sigma, &window.camera);
  factor.loss = loss_.get();
  graph->AddFactor(std::move(factor), {rho_block});
}

void InverseVirtualDepthTerm::Reject(const FactorGraph::Factor& /*factor*/,
                                     Point* point,
                                     Window* /*window*/) const {
  point->w_sigma = 0;
}

}  // namespace prism
