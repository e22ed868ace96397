// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/shared_depths.h"

#include <cmath>

namespace prism {

std::vector<double> NumSharingDepth(const std::vector<Eigen::Vector2i>& pixels,
                                    double correlation_px) {
  std::vector<double> counts(pixels.size(), 1.0);
  if (correlation_px <= 0) return counts;
  const double exponent = -0.5 / (correlation_px * correlation_px);
  const double reach_squared = 12 * correlation_px * correlation_px;  // correlation 0.0025
  for (size_t i = 0; i < pixels.size(); ++i) {
    for (size_t j = i + 1; j < pixels.size(); ++j) {
      const double distance_squared = (pixels[i] - pixels[j]).squaredNorm();
      if (distance_squared > reach_squared) continue;
      const double correlation = std::exp(exponent * distance_squared);
      counts[i] += correlation;
      counts[j] += correlation;
    }
  }
  return counts;
}

}  // namespace prism
