// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "prism/eval/association.h"

namespace prism {

// Relative pose errors of a set of pose pairs (i, j):
//   E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j),  Q ground truth, P estimate, both world_from_cam
// (Sturm et al., A benchmark for the evaluation of RGB-D SLAM systems, IROS 2012, Eq. (2)).
// No alignment takes part; the scale of the estimate does.
struct RelativeError {
  double trans_rmse_m = 0;  // of |translation of E|
  double rot_rmse_deg = 0;  // of the angle of E
  int count = 0;            // pairs
};

// Every i with the j whose time is nearest to t_i + interval_ns, if it is within tolerance_ns of
// that. Nothing if there is no such pair.
std::optional<RelativeError> RelativeErrorOverTime(const std::vector<PosePair>& poses,
                                                   int64_t interval_ns,
                                                   int64_t tolerance_ns);

// Every i with the first j at which the ground-truth path from i has reached distance_m. Errors are
// those over the whole piece, not per metre. Nothing if the path is shorter.
std::optional<RelativeError> RelativeErrorOverDistance(const std::vector<PosePair>& poses,
                                                       double distance_m);

// Length of the ground-truth path from the first pose to each pose, in metres.
std::vector<double> GroundtruthPath(const std::vector<PosePair>& poses);

}  // namespace prism
