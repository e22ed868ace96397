// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "prism/geometry/se3.h"

namespace prism {

// A pose measured between two keyframes.
struct PoseEdge {
  int from = 0;  // keyframe ids
  int to = 0;
  SE3 to_from_from;
  Matrix6d information = Matrix6d::Identity();  // of it, tangent on its left; positive definite
  bool is_loop = false;  // found by what the views look like, so that it may be wrong: robust
};

// The information of an edge from that of an alignment, which knows of noise only: its translation
// may be too long or too short by a share of its length as well, and turned by what looks the same
// at the median inverse depth of the points (1/m), as their depths are off in common.
Matrix6d EdgeInformation(const Matrix6d& alignment_information,
                         const SE3& to_from_from,
                         double median_rho);

// Poses cam_from_world (by keyframe id) that fit all edges best: the sum over edges of
//   rho(|| L^T Log(T_to T_from^-1 T_measured^-1) ||^2),   L L^T = information,
// with Cauchy's rho (scale 10: stated deviations are those of noise) for loops, by Ceres. The poses
// `held` stay; others without a chain of edges to one of them must not be. Edges to poses that are
// not given are left out.
void OptimizePoses(const std::vector<PoseEdge>& edges,
                   const std::vector<int>& held,
                   std::map<int, SE3>* poses);

}  // namespace prism
