// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace prism {

struct PlyPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // metres
  std::array<uint8_t, 3> rgb{};
};

// Writes a binary little-endian PLY with x, y, z (float) and red, green, blue (uchar), whole or not
// at all. Throws InputError if it cannot.
void WritePly(const std::string& path, const std::vector<PlyPoint>& points);

}  // namespace prism
