// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/camera/plenoptic_camera.h"
#include "prism/factors/pixel_residuals.h"
#include "prism/image/pyramid.h"

namespace prism {

// A point a new frame is aligned to: a pixel of the reference keyframe with its inverse depth.
struct ReferencePoint {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // focused px of level 0, in the reference keyframe
  double rho = 0;                                // 1/m, there
  double rho_sigma = 0;                          // its standard deviation; 0: known exactly
  int point_id = -1;                             // Point::id
  // Found to be hidden, or to move by itself: alignments do without it.
  bool is_excluded = false;
};

// The reference keyframe as the tracker sees it; built once a keyframe by MakeTrackingReference.
struct TrackingReference {
  // The pixels of all points, point by point; places of pixels outside the image are empty.
  struct Level {
    ReferencePixels pixels;
    int pixels_per_point = 1;  // 1 or kPatternSize
    int count = 0;             // of pixels that are there
  };
  std::vector<ReferencePoint> points;
  std::vector<PlenopticProjection> cameras;  // one a level
  std::vector<Level> levels;                 // level 0 finest
  int NumLevels() const { return static_cast<int>(levels.size()); }
  bool empty() const { return levels.empty() || levels[0].count == 0; }
};

// Calls visit(pixel, index of its point) for every pixel of a level.
template <typename Visit>
void ForEachPixel(const TrackingReference::Level& level, const Visit& visit) {
  for (size_t i = 0; i < level.pixels.size(); ++i) {
    if (level.pixels.Holds(i)) visit(level.pixels.at(i), i / level.pixels_per_point);
  }
}

// Samples the reference image at the points on every level: the pattern of DSO on level 0, the
// pixel alone on coarser levels. `image` is the reference keyframe's pyramid.
TrackingReference MakeTrackingReference(const PlenopticCamera& camera,
                                        const ImagePyramid& image,
                                        const std::vector<ReferencePoint>& points);

}  // namespace prism
