// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/points/candidates.h"
#include "prism/points/selection.h"

namespace prism {

struct ActivationOptions {
  PointSelectionOptions selection;
  // Its gradient_margin where depth was found in micro images, whose errors the points of weak
  // patches share (docs/depth.md).
  double micro_image_gradient_margin = 14;
  CandidateOptions candidates;
  RefinementOptions refinement;
  int max_new_points = 600;    // activated per keyframe
  int min_point_distance = 4;  // px between active points in the newest keyframe

  bool IsValid(std::string* error) const;
};

// Gives the newest keyframe of the window its points, at most `max_points` in all keyframes, or
// half of that seen by the newest one if that is more: certain candidates of the others first, then
// new ones where a depth is measured. Where none is, candidates are left for motion to tell their
// depth.
void ActivatePoints(const ActivationOptions& options,
                    const TermList& terms,
                    int max_points,
                    Window* window);

}  // namespace prism
