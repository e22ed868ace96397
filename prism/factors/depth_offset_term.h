// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <ceres/cost_function.h>

#include "prism/factors/term.h"

namespace prism {

// Errors of measured inverse virtual depth that all points of a keyframe share:
//   w_measured = w(rho) + offset_k + noise,  offset_k = delta + delta_k.
// delta persists (calibration of b_L0, the scene's kind of texture) and drifts slowly from keyframe
// to keyframe; delta_k is the keyframe's own. Without them hundreds of depths count as independent
// measurements of scale, which they are not (docs/depth.md).
//
// States of a keyframe, in units of 1/v:
//   "depth offset"             delta + delta_k, what its depths are off by (DepthOffset)
//   "persistent depth offset"  delta at that keyframe
// each where it is asked for; with delta alone depths are off by that.
struct DepthOffsetTermOptions {
  bool per_keyframe = true;  // false: delta_k is 0 (ablation)
  // Standard deviations of delta before anything is measured (0: it is 0, as errors that depend on
  // distance pass for it, docs/depth.md), and of its step between keyframes.
  // That of delta_k is NoiseModel::DepthOffsetSigma.
  double prior_sigma = 0;
  double step_sigma = 0.0001;

  bool has_persistent() const { return prior_sigma > 0; }

  bool IsValid(std::string* error) const;
};

// The block of what a keyframe's depths are off by; -1: there is none.
int DepthOffsetBlock(const WindowGraph& graph, const Keyframe& keyframe);
// The same of the part that later keyframes share; -1: it is no state.
int PersistentDepthOffsetBlock(const WindowGraph& graph, const Keyframe& keyframe);
// What is known of the offset of a keyframe's depths; 0 if it has no such state.
double DepthOffset(const Keyframe& keyframe);
// The part that later keyframes share; where it is no state, the whole.
double PersistentDepthOffset(const Keyframe& keyframe);

// Adds the states with what is known of delta before any measurement, and factors between them: the
// steps of delta, and delta_k.
class DepthOffsetTerm : public Term {
 public:
  explicit DepthOffsetTerm(const DepthOffsetTermOptions& options);

  static constexpr char kName[] = "depth offset";
  std::string name() const override { return kName; }
  void AddStates(Window* window) const override;
  void AddFactors(const Window& window, WindowGraph* graph) const override;

 private:
  DepthOffsetTermOptions options_;
};

// r = (x_1 - x_0) / sigma of two offsets, or (x_0 - 0) / sigma of one.
// Residuals: 1. Parameter blocks: 1 or 2 of size 1. Precondition: sigma > 0.
class OffsetDifferenceCost : public ceres::CostFunction {
 public:
  OffsetDifferenceCost(int num_blocks, double sigma);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  double inverse_sigma_;
};

}  // namespace prism
