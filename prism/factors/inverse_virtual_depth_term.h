// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include <ceres/cost_function.h>

#include "prism/camera/projection.h"
#include "prism/factors/term.h"

namespace prism {

// Inverse virtual depth residual of one point in its host frame, Eq. (22) over its standard
// deviation: r = (w(rho) + offset_gain offset - w_measured) / sigma with w = 1/v, the only residual
// that holds the scale.
//
// Residuals: 1. Parameter blocks: metric inverse depth rho in 1/m (1), and, if `offset_gain` is not
// 0, the offset that the depths of the frame it was measured in have in common (1;
// DepthOffsetTerm). The gain is 1 for the host, and TransferredDepth::gain for another frame.
// Jacobian: Eq. (87), last line. Poses and brightness do not enter (Eqs. (26), (76)). A point at or
// inside the focal length gives zero residual and Jacobian. Precondition: sigma > 0. `camera` must
// outlive the cost.
class InverseVirtualDepthCost : public ceres::CostFunction {
 public:
  InverseVirtualDepthCost(double w_measured,
                          double sigma,
                          double offset_gain,
                          const PlenopticProjection* camera);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  double w_measured_;
  double inverse_sigma_;
  double offset_gain_;
  const PlenopticProjection* camera_;
};

struct InverseVirtualDepthTermOptions {
  double huber = 1.5;         // standard deviations; 0: squares (ablation)
  double max_residual = 3.5;  // standard deviations: beyond it the measurement is dropped
  // Also what the other keyframes measured where they see a point; false: only its host (ablation).
  bool of_all_keyframes = true;

  bool IsValid(std::string* error) const;
};

// An InverseVirtualDepthCost for every keyframe that measured a depth where it sees the point. What
// others than its host measured is transferred to the host with the poses as they are when factors
// are made: images tell them far better than depths, and their share in the depth is small.
class InverseVirtualDepthTerm : public Term {
 public:
  explicit InverseVirtualDepthTerm(const InverseVirtualDepthTermOptions& options);

  static constexpr char kName[] = "inverse virtual depth";
  // Group of the factor of what the host measured; that of another keyframe's is its id.
  static constexpr int kHost = -1;
  std::string name() const override { return kName; }
  void AddPointFactors(const Window& window,
                       size_t host_index,
                       const Point& point,
                       int rho_block,
                       WindowGraph* graph) const override;
  OutlierRule outlier_rule() const override { return {options_.max_residual}; }
  // The measurement is forgotten (Point::w_sigma, Point::depth_outlier_targets).
  void Reject(const FactorGraph::Factor& factor, Point* point, Window* window) const override;

 private:
  InverseVirtualDepthTermOptions options_;
  std::unique_ptr<const ceres::LossFunction> loss_;
};

}  // namespace prism
