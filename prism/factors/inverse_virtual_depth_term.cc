// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/inverse_virtual_depth_term.h"

#include <glog/logging.h>

#include "prism/factors/depth_offset_term.h"

namespace prism {

InverseVirtualDepthCost::InverseVirtualDepthCost(double w_measured,
                                                 double sigma,
                                                 bool has_offset,
                                                 const PlenopticProjection* camera)
    : w_measured_(w_measured), inverse_sigma_(1 / sigma), has_offset_(has_offset), camera_(camera) {
  CHECK_GT(sigma, 0);
  set_num_residuals(1);
  mutable_parameter_block_sizes()->assign(has_offset ? 2 : 1, 1);
}

bool InverseVirtualDepthCost::Evaluate(double const* const* parameters,
                                       double* residuals,
                                       double** jacobians) const {
  const double rho = parameters[0][0];
  const double expected = w_measured_ - (has_offset_ ? parameters[1][0] : 0);
  double dw_drho;
  const double w = InverseVirtualDepth(*camera_, rho, &dw_drho);
  const bool valid = rho * camera_->f < 1 && w > 0;
  residuals[0] = valid ? (w - expected) * inverse_sigma_ : 0;
  if (jacobians == nullptr) return true;
  if (jacobians[0] != nullptr) jacobians[0][0] = valid ? dw_drho * inverse_sigma_ : 0;
  if (has_offset_ && jacobians[1] != nullptr) jacobians[1][0] = valid ? inverse_sigma_ : 0;
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
                                              size_t host_index,
                                              const Point& point,
                                              int rho_block,
                                              WindowGraph* graph) const {
  if (!(point.w_sigma > 0)) return;
  std::vector<int> blocks = {rho_block};
  const int offset = DepthOffsetBlock(*graph, *window.keyframes[host_index]);
  if (offset >= 0) blocks.push_back(offset);
  FactorGraph::NewFactor factor;
  factor.cost = std::make_unique<InverseVirtualDepthCost>(
      point.w_measured, window.noise.DepthScale() * point.w_sigma, offset >= 0, &window.camera);
  factor.loss = loss_.get();
  factor.keeps_first_estimates = true;  // it is linear in the offset
  graph->AddFactor(std::move(factor), blocks);
}

void InverseVirtualDepthTerm::Reject(const FactorGraph::Factor& /*factor*/,
                                     Point* point,
                                     Window* /*window*/) const {
  point->w_sigma = 0;
}

}  // namespace prism
