// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/coverage.h"

#include <algorithm>
#include <cmath>

#include "prism/factors/visibility.h"

namespace prism {

CoverageMap::CoverageMap(const Window& window)
    : columns_(window.camera.width / kCell + 1),
      rows_(window.camera.height / kCell + 1),
      first_(static_cast<size_t>(columns_) * rows_, -1) {
  const Keyframe& newest = window.newest();
  for (const auto& host : window.keyframes) {
    const RigidMotion newest_from_host(newest.state.pose() * host->state.pose().Inverse());
    for (const auto& point : host->points) {
      Eigen::Vector3d x_V;
      if (!IsHidden(*point, newest) &&
          ProjectBetweenFrames(
              window.camera, point->patch.px, point->rho, newest_from_host, &x_V)) {
        Add(x_V.head<2>());
      }
    }
  }
}

void CoverageMap::Add(const Eigen::Vector2d& px) {
  const int column = static_cast<int>(std::floor(px.x() / kCell));
  const int row = static_cast<int>(std::floor(px.y() / kCell));
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  int& head = first_[static_cast<size_t>(row) * columns_ + column];
  next_.push_back(head);
  points_.push_back(px);
  head = static_cast<int>(points_.size()) - 1;
}

bool CoverageMap::IsFree(int x, int y, int radius) const {
  const int column0 = std::max((x - radius) / kCell, 0);
  const int row0 = std::max((y - radius) / kCell, 0);
  const int column1 = std::min((x + radius) / kCell, columns_ - 1);
  const int row1 = std::min((y + radius) / kCell, rows_ - 1);
  for (int row = row0; row <= row1; ++row) {
    for (int column = column0; column <= column1; ++column) {
      for (int i = first_[static_cast<size_t>(row) * columns_ + column]; i >= 0; i = next_[i]) {
        if ((points_[i] - Eigen::Vector2d(x, y)).cwiseAbs().maxCoeff() <= radius) return false;
      }
    }
  }
  return true;
}

}  // namespace prism
