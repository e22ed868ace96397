// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/inverse_virtual_depth_term.h"

#include <cmath>

#include <glog/logging.h>

#include "prism/factors/depth_offset_term.h"
#include "prism/factors/transferred_depth.h"
#include "prism/factors/visibility.h"

namespace prism {
namespace {

// What the target measured where it sees the point. Nothing where it did not.
std::optional<TransferredDepth> DepthMeasuredIn(const Keyframe& target,
                                                const PlenopticProjection& camera,
                                                const RigidMotion& target_from_host,
                                                const Point& point,
                                                double* sigma) {
  const LightFieldFrame& frame = *target.frame;
  Eigen::Vector3d x_V;
  if (frame.sigma.size() == 0 || !IsObserved(camera, target_from_host, point, target, &x_V)) {
    return std::nullopt;
  }
  const int x = static_cast<int>(std::lround(x_V.x()));
  const int y = static_cast<int>(std::lround(x_V.y()));
  *sigma = frame.sigma(x, y);
  if (!(*sigma > 0)) return std::nullopt;
  return TransferDepth(camera, target_from_host, point.patch.px, frame.inverse_virtual_depth(x, y));
}

}  // namespace

InverseVirtualDepthCost::InverseVirtualDepthCost(double w_measured,
                                                 double sigma,
                                                 double offset_gain,
                                                 const PlenopticProjection* camera)
    : w_measured_(w_measured),
      inverse_sigma_(1 / sigma),
      offset_gain_(offset_gain),
      camera_(camera) {
  CHECK_GT(sigma, 0);
  set_num_residuals(1);
  mutable_parameter_block_sizes()->assign(offset_gain != 0 ? 2 : 1, 1);
}

bool InverseVirtualDepthCost::Evaluate(double const* const* parameters,
                                       double* residuals,
                                       double** jacobians) const {
  const double rho = parameters[0][0];
  const double expected = w_measured_ - (offset_gain_ != 0 ? offset_gain_ * parameters[1][0] : 0);
  double dw_drho;
  const double w = InverseVirtualDepth(*camera_, rho, &dw_drho);
  const bool valid = rho * camera_->f < 1 && w > 0;
  residuals[0] = valid ? (w - expected) * inverse_sigma_ : 0;
  if (jacobians == nullptr) return true;
  if (jacobians[0] != nullptr) jacobians[0][0] = valid ? dw_drho * inverse_sigma_ : 0;
  if (offset_gain_ != 0 && jacobians[1] != nullptr) {
    jacobians[1][0] = valid ? offset_gain_ * inverse_sigma_ : 0;
  }
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
  const auto add = [&](const Keyframe& keyframe, int group, double w, double sigma, double gain) {
    std::vector<int> blocks = {rho_block};
    const int offset = DepthOffsetBlock(*graph, keyframe);
    if (offset >= 0) blocks.push_back(offset);
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<InverseVirtualDepthCost>(
        w, window.noise.DepthScale() * sigma, offset >= 0 ? gain : 0, &window.camera);
    factor.loss = loss_.get();
    factor.group = group;
    factor.keeps_first_estimates = true;  // it is linear in the offset
    graph->AddFactor(std::move(factor), blocks);
  };
  if (point.w_sigma > 0) {
    add(*window.keyframes[host_index], kHost, point.w_measured, point.w_sigma, 1);
  }
  if (!options_.of_all_keyframes) return;
  for (size_t j = 0; j < window.keyframes.size(); ++j) {
    const Keyframe& target = *window.keyframes[j];
    if (j == host_index || IsDepthOutlier(point, target)) continue;
    double sigma = 0;
    const std::optional<TransferredDepth> depth = DepthMeasuredIn(
        target, window.camera, graph->pair(host_index, j).current.target_from_host, point, &sigma);
    if (!depth) continue;
    // Points are as dense in the target as in the host, and share their errors as much.
    sigma *= std::sqrt(point.depth_sharing);
    add(target, target.id, depth->w, depth->gain * sigma, depth->gain);
  }
}

void InverseVirtualDepthTerm::Reject(const FactorGraph::Factor& factor,
                                     Point* point,
                                     Window* /*window*/) const {
  if (factor.group == kHost) {
    point->w_sigma = 0;
  } else {
    point->depth_outlier_targets.push_back(factor.group);
  }
}

}  // namespace prism
