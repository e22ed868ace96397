// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/factors/term.h"

namespace prism {

struct OutlierResult {
  std::vector<int> factors_rejected;  // one a term, in the order of the terms
  int points_dropped = 0;
};

// Judges every factor of the window by its term's rule (Term::outlier_rule, Term::Reject), then
// drops points left without a factor that ties them to frames, if they had one, and points at or
// inside the focal length or behind the camera.
OutlierResult RemoveOutliers(const TermList& terms,
                             const WindowGraphOptions& options,
                             Window* window);

}  // namespace prism
