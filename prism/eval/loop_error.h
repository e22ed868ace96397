// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "prism/eval/association.h"

namespace prism {

// Drift between the start and the end of a sequence whose ground truth need only cover both ends
// (Engel, Usenko, Cremers, A photometrically calibrated benchmark for monocular visual odometry,
// arXiv:1607.02555). With x_gt = s R x + t aligned on the start (A) and on the end (E):
struct LoopError {
  double e_s = 1;          // scale drift, max(s_A / s_E, s_E / s_A), no unit, 1 is none
  double e_r_deg = 0;      // rotation drift, the angle of R_E R_A^T in degrees
  double e_align_m = 0;    // RMS over all estimated poses of the distance between their two images
  double scale_start = 1;  // s_A
  double scale_end = 1;    // s_E
};

// The first and the last segment_size pairs are A and E. Nothing if there are fewer than
// 2 segment_size pairs, segment_size is below 3, or a segment cannot be aligned (the camera did not
// move in it).
std::optional<LoopError> ComputeLoopError(const std::vector<PosePair>& pairs,
                                          const Trajectory& estimate,
                                          int segment_size);

}  // namespace prism
