// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/image/noise.h"

#include <cmath>
#include <vector>

#include "prism/base/statistics.h"

namespace prism {

double EstimateImageNoise(const ImageViewF& image) {
  std::vector<double> magnitudes;
  for (int y = 1; y + 1 < image.height; y += 2) {
    const float* above = image.row(y - 1);
    const float* here = image.row(y);
    const float* below = image.row(y + 1);
    for (int x = 1; x + 1 < image.width; x += 2) {
      if (here[x] <= 1 || here[x] >= 254) continue;
      const double second_difference = above[x - 1] - 2 * above[x] + above[x + 1] -
                                       2 * here[x - 1] + 4 * here[x] - 2 * here[x + 1] +
                                       below[x - 1] - 2 * below[x] + below[x + 1];
      magnitudes.push_back(std::abs(second_difference));
    }
  }
  // The mask multiplies the standard deviation by 6; the median of |N(0, 1)| is 0.6745.
  return Quantile(std::move(magnitudes), 0.5) / (6 * 0.6745);
}

}  // namespace prism
