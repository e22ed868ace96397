// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace prism {

struct PlyPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // metres
  uint8_t intensity = 0;
};

// Writes a binary little-endian PLY with x, y, z (float) and red, green, blue (uchar, all equal to
// the intensity, which is what viewers show), whole or not at all. Throws InputError if it cannot.
void WritePly(const std::string& path, const std::vector<PlyPoint>& points);

}  // namespace prism
