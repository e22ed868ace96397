// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "prism/factors/term.h"
#include "prism/solver/schur_complement.h"
#include "prism/window/options.h"

namespace prism {

struct RetirementOptions {
  double min_visible_fraction = 0.05;  // of a keyframe's points, in the newest keyframe
  double max_log_gain = 1.5;           // |a - a_newest|

  bool IsValid(std::string* error) const;
};

// Ids of the keyframes that should leave, so that the next one is at most the `max_keyframes`th:
// few of their points are visible in the newest keyframe, their brightness differs too much, or the
// window is too long and DSO's distance score is highest (far from the newest, close to the
// others). The two newest stay.
std::vector<int> KeyframesToRetire(const WindowOptions& window_options,
                                   const RetirementOptions& options,
                                   const Window& window);

// What a point was when it left, for the map. There are a hundred a frame: kept small.
struct RetiredPoint {
  int keyframe_id = 0;
  Eigen::Vector3f x_C = Eigen::Vector3f::Zero();  // metres, in its host's camera frame
  Eigen::Vector2f px = Eigen::Vector2f::Zero();   // in its host, focused px
  float rho_sigma = 0;                            // of its inverse depth, 1/m; 0: not known
  std::array<uint8_t, 3> rgb{};                   // gray where its host has no colour
};

struct RetirementResult {
  std::vector<RetiredPoint> points;
  int marginalized_points = 0;
  int dropped_points = 0;
  RankReport rank;  // of the prior afterwards
};

// Takes one keyframe out of the window. Its states and points, and points seen by neither of the
// two newest keyframes, are marginalised with the factors that tie them (MarginalizeBlocks): the
// prior takes up what they knew, and what shares it gets its first estimate. Residuals of other
// points in the leaving keyframe are dropped. Without `marginalization_prior` all is dropped.
RetirementResult RetireKeyframe(const WindowOptions& options,
                                const TermList& terms,
                                int keyframe_id,
                                Window* window);

// Empties a window that is given up; what its points were, for the map. States of the run keep
// their values.
std::vector<RetiredPoint> ForgetWindow(Window* window);

// A point as the map keeps it.
RetiredPoint MakeRetiredPoint(const PlenopticProjection& camera,
                              const Keyframe& host,
                              const Point& point);

}  // namespace prism
