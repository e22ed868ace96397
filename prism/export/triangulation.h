// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/export/tracks.h"

namespace prism {

struct TriangulatedPoint {
  Eigen::Vector3d p_in_world = Eigen::Vector3d::Zero();
  double mean_error = 0;  // px, over all observations
};

// Where the observations of a track meet, keyframes held: the least sum of reprojection errors,
// beyond `kink_px` taken as they are instead of squared. Begins at `start`, and stays there where
// it would leave a keyframe's view.
TriangulatedPoint Triangulate(const PlenopticProjection& camera,
                              const std::vector<SE3>& cam_from_world,  // by keyframe
                              const Track& track,
                              const Eigen::Vector3d& start,
                              double kink_px = 0.5);

// The same without observations that are further than `max_error_px` from where the others meet,
// which are taken out of the track: patches that slid along an edge.
TriangulatedPoint TriangulateWithoutOutliers(const PlenopticProjection& camera,
                                             const std::vector<SE3>& cam_from_world,
                                             const Eigen::Vector3d& start,
                                             Track* track,
                                             double max_error_px = 1);

}  // namespace prism
