// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prism/export/export_run.h"

namespace prism {

struct OrientedPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // metres
  // Unit vector to the camera that measured it: it orients a surface, and tells what was free.
  Eigen::Vector3f view_direction = Eigen::Vector3f::Zero();
  std::array<uint8_t, 3> rgb{};
  float sigma_m = 0;  // along that direction; 0: not known
};

// The points of the map.
std::vector<OrientedPoint> SparsePoints(const ExportRun& run);

// Binary little-endian PLY: x, y, z, nx, ny, nz (the viewing direction, where programs look for
// normals), red, green, blue, sigma. Throws InputError if it cannot be written.
void WriteOrientedPly(const std::string& path, const std::vector<OrientedPoint>& points);

// FOLDER/points_oriented.ply with SparsePoints; returns one line about it.
std::string WriteSparsePly(const std::string& folder, const ExportRun& run);

}  // namespace prism
