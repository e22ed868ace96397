// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "prism/image/image.h"

namespace prism {

struct PointSelectionOptions {
  int region_size = 32;        // px: side of the regions whose median gradient is the threshold
  double gradient_margin = 7;  // 0 to 255 a px, added to the region's median
  int border = 4;              // px kept free at the image border
  int max_cell_size = 40;      // px: coarsest spread of the points

  bool IsValid(std::string* error) const;
};

// Pixels with enough gradient, spread over the image as in DSO (Section 3.2 of the paper): the
// strongest gradient of each cell that exceeds the smoothed median of its region by a margin, with
// the cell size chosen so that about `count` pixels are found. In cells of weak gradient a second
// pass takes pixels above half that threshold from cells twice as large.
//
// `squared_gradient` as of SquaredGradientMagnitude; `is_usable(x, y)` says where a point may start
// (a depth measurement, no other point near). Deterministic. Fewer points, down to none, if the
// image does not have them.
std::vector<Eigen::Vector2i> SelectPoints(const ImageViewF& squared_gradient,
                                          int count,
                                          const std::function<bool(int x, int y)>& is_usable,
                                          const PointSelectionOptions& options);

}  // namespace prism
