// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace prism {

// Brightness of a plane covered with speckles of many sizes, no two areas of which look alike:
// value noise over hashed lattices. 0 to 255.
inline double SpeckleTexture(double x, double y) {
  const auto hash = [](int64_t i, int64_t j, int64_t layer) {
    uint64_t h = static_cast<uint64_t>(i) * 0x9E3779B97F4A7C15u ^
                 static_cast<uint64_t>(j) * 0xC2B2AE3D27D4EB4Fu ^
                 static_cast<uint64_t>(layer + 1) * 0x165667B19E3779F9u;
    h ^= h >> 31;
    h *= 0xD6E8FEB86659FD93u;
    h ^= h >> 32;
    return static_cast<double>(h % 1000) / 1000 - 0.5;
  };
  double value = 128;
  const double cells_m[] = {0.4, 0.15, 0.06, 0.025};
  for (int layer = 0; layer < 4; ++layer) {
    const double u = x / cells_m[layer], v = y / cells_m[layer];
    const double i = std::floor(u), j = std::floor(v);
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double s = smooth(u - i), t = smooth(v - j);
    const auto at = [&](int di, int dj) {
      return hash(static_cast<int64_t>(i) + di, static_cast<int64_t>(j) + dj, layer);
    };
    value += 90 * ((1 - s) * ((1 - t) * at(0, 0) + t * at(0, 1)) +
                   s * ((1 - t) * at(1, 0) + t * at(1, 1)));
  }
  return std::fmin(std::fmax(value, 0), 255);
}

}  // namespace prism
