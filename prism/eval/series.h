// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "prism/eval/association.h"
#include "prism/eval/metrics.h"

namespace prism {

struct TimedValue {
  int64_t time_ns = 0;
  double value = 0;
};

// Distance in metres of each estimated position from the true one after the SE3 alignment of the
// whole trajectory.
std::vector<TimedValue> ErrorOverTime(const std::vector<PosePair>& pairs,
                                      const SE3& gt_from_estimate);

struct ScaleSeriesOptions {
  int64_t window_ns = 3000000000;  // length of the window the scale is fitted in, ns
  int max_count = 400;             // windows at most, spread evenly over the poses
  double min_spread_m = 0.02;      // RMS distance of the true positions from their mean, metres
};

// Scale s of the Sim3 that fits the estimate to the ground truth in a window about each time (1:
// metric). Left out where the window has fewer than 3 poses, or too little motion to tell.
std::vector<TimedValue> ScaleOverTime(const std::vector<PosePair>& pairs,
                                      const ScaleSeriesOptions& options = {});

}  // namespace prism
