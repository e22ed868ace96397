// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/window/window.h"

namespace prism {

// A depth estimate of one point against the other keyframes of the window, their poses held.
struct DepthRefinement {
  bool success = false;
  double rho = 0;           // 1/m
  double rho_variance = 0;  // 1/m^2, of the photometric residuals and the measurement together
  double rms = 0;           // of the photometric residuals, in standard deviations
  int observations = 0;     // target frames
};

struct RefinementOptions {
  int max_iterations = 5;
  double max_rms = 3;               // standard deviations: a worse fit is no match
  double max_relative_sigma = 0.5;  // of rho: a less certain depth is no success
};

// Gauss-Newton on the inverse depth of one point hosted by `window.keyframes[host_index]`:
// photometric residuals to all other keyframes in which it is seen, and its measured inverse
// virtual depth if it has one. Fails if nothing observes the point, the residuals stay large or the
// depth uncertain; a point that has a measurement but is seen nowhere else succeeds with the
// measurement.
DepthRefinement RefineInverseDepth(const Window& window,
                                   const WindowOptions& window_options,
                                   size_t host_index,
                                   const Point& point,
                                   const RefinementOptions& options);

// Where new points are wanted: distance in px to the nearest active point, of all keyframes,
// projected into the newest one.
class CoverageMap {
 public:
  explicit CoverageMap(const Window& window);
  // True if no active point lies within `radius` px (Chebyshev) of the pixel.
  bool IsFree(int x, int y, int radius) const;
  void Add(const Eigen::Vector2d& px);

 private:
  static constexpr int kCell = 4;  // px
  int columns_, rows_;
  std::vector<int> first_;  // index into next_/points of each cell's list, -1 none
  std::vector<int> next_;
  std::vector<Eigen::Vector2d> points_;
};

}  // namespace prism
