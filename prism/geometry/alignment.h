// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "prism/geometry/se3.h"

namespace prism {

// A similarity transformation x_target = scale R x_source + t.
struct Sim3 {
  double scale = 1;
  SE3 rigid;  // rotation and translation

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const {
    return scale * (rigid.rotation() * p) + rigid.translation();
  }
};

struct AlignmentResult {
  bool success = false;  // false: fewer than 3 points
  Sim3 target_from_source;
  double rmse = 0;  // of the distances left, in the unit of the points
};

// The rigid (scale held at 1) or similarity transformation that minimises the sum of squared
// distances between target[i] and its image of source[i], in closed form:
// S. Umeyama, Least-squares estimation of transformation parameters between two point patterns,
// PAMI 1991. Both lists have one length. Collinear points leave the rotation about their line free;
// a rotation is returned all the same.
AlignmentResult AlignPoints(const std::vector<Eigen::Vector3d>& source,
                            const std::vector<Eigen::Vector3d>& target,
                            bool with_scale);

}  // namespace prism
