// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/scene/window.h"

namespace prism {

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
