// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "prism/factors/window_graph.h"

namespace prism {

// What a window that has been optimised knows of its metric scale and of the offsets of its depths.
struct WindowUncertainty {
  double path_m = 0;         // from keyframe to keyframe
  double newest_step_m = 0;  // to the newest of them
  // Standard deviation of ln(path_m): relative, of the metric scale. Where keyframes have offsets
  // of their own and what they share is no state (PersistentDepthOffsetBlock), that is taken to be
  // off by as much (NoiseModel::DepthOffsetSigma), as it is no better known (docs/depth.md).
  double scale_sigma = 0;
  // What the newest keyframe's depths share with later ones (PersistentDepthOffset); 0 without.
  double depth_offset = 0;
  double depth_offset_sigma = 0;
  // Expected square of the keyframes' own offsets, delta_k: of their estimates plus their variance
  // (the M step of expectation maximisation); 0 without.
  double keyframe_offset_square = 0;
};

// From the covariance of the states (EvaluateBlockCovariance), first-order. Nothing if they are not
// determined or the window has one keyframe. Precondition: the graph is prepared at the optimum.
std::optional<WindowUncertainty> EvaluateUncertainty(const Window& window,
                                                     const WindowGraph& graph);

}  // namespace prism
