// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/window/window.h"

namespace prism {

struct OutlierOptions {
  // A pattern's RMS residual (standard deviations) above
  // (base_rms + quantile_factor * its `quantile` over the target frame) / 2 is an outlier there
  // (DSO's frame energy threshold).
  double base_rms = 3;
  double quantile = 0.7;
  double quantile_factor = 2;
};

struct OutlierResult {
  int observations_dropped = 0;
  int points_dropped = 0;
  int depth_measurements_dropped = 0;
};

// Marks observations with large residuals as outliers, drops points left without an observation
// that had one, and drops depth measurements that disagree with the optimised depth.
OutlierResult RemoveOutliers(const WindowOptions& window_options,
                             const OutlierOptions& options,
                             Window* window);

}  // namespace prism
