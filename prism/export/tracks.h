// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "prism/export/export_run.h"

namespace prism {

struct TrackOptions {
  int max_distance = 8;  // keyframes before and after the host that are searched
  // Not searched where the point is seen this much smaller or larger than in its host, or the
  // camera has turned about its axis by more.
  double max_scale = 1.4;
  double max_roll_deg = 15;
  // Matches are dropped that move from where the point projects by more, or do not come back to
  // where they started when looked for the other way about; px.
  double max_reprojection = 2;
  double max_return = 0.4;
};

// Where a point is seen in a keyframe.
struct Observation {
  int keyframe = 0;                              // index into ExportRun::keyframes
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // focused px
};

struct Track {
  std::vector<Observation> observations;  // by rising keyframe, the host's among them
  double mean_error = 0;                  // px, of those outside the host; 0 if there are none
};

// For each point the keyframes that see it, and where they do: the patch around it is looked for in
// their images (Lucas-Kanade, whatever the exposure), from where the point projects. The places are
// thus measured, and their distance from the projections is an error. The odometry itself has no
// such places: it compares intensities at the projections.
std::vector<Track> FindTracks(const ExportRun& run, const TrackOptions& options = {});

// Projection of a point in the world into a keyframe. False if it is not before the front focal
// point.
bool ProjectToKeyframe(const PlenopticProjection& camera,
                       const SE3& cam_from_world,
                       const Eigen::Vector3d& p_in_world,
                       Eigen::Vector2d* px);

}  // namespace prism
