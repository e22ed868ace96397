// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/marginalize/marginalize.h"
#include "prism/window/window.h"

namespace prism {

struct RetirementOptions {
  double min_visible_fraction = 0.05;  // of a keyframe's points, in the newest keyframe
  double max_log_gain = 0.7;           // |a - a_newest|
};

// Ids of the keyframes that should leave: few of their points are visible in the newest keyframe,
// their brightness differs too much, or the window is too long and DSO's distance score is highest
// (far from the newest, close to the others). The two newest stay.
std::vector<int> KeyframesToRetire(const WindowOptions& window_options,
                                   const RetirementOptions& options,
                                   const Window& window);

// What a point was when it left, for the map.
struct RetiredPoint {
  int keyframe_id = 0;
  Eigen::Vector3d x_C = Eigen::Vector3d::Zero();  // metres, in its host's camera frame
  float intensity = 0;                            // 0 to 255
};

struct RetirementResult {
  std::vector<RetiredPoint> points;
  int marginalized_points = 0;
  int dropped_points = 0;
  RankReport rank;  // of the prior afterwards
};

// Takes one keyframe out of the window. Its points, and points seen by neither of the two newest
// keyframes, are marginalised with all their residuals; residuals of other points in the leaving
// keyframe are dropped (they would fill the Hessian, as in DSO). The prior takes up what they knew;
// frames that share it get their first estimate. Without `marginalization_prior` all is dropped.
RetirementResult RetireKeyframe(const WindowOptions& options, int keyframe_id, Window* window);

// Takes the oldest keyframe out without a trace in the prior, for a window that is given up: the
// prior is dropped with it.
RetirementResult ForgetOldestKeyframe(Window* window);

}  // namespace prism
