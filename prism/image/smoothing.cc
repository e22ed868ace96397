// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/image/smoothing.h"

#include <algorithm>

namespace prism {

void SmoothRow(const ImageViewF& image, int y, float* smooth) {
  SmoothRow(image.row(std::max(y - 1, 0)),
            image.row(y),
            image.row(std::min(y + 1, image.height - 1)),
            image.width,
            smooth);
}

void SmoothRow(
    const float* above, const float* here, const float* below, int width, float* smooth) {
  smooth[0] = here[0];
  smooth[width - 1] = here[width - 1];
  for (int x = 1; x < width - 1; ++x) {
    smooth[x] = (above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1] +
                 2 * (above[x] + below[x] + here[x - 1] + here[x + 1]) + 4 * here[x]) *
                (1.0f / 16);
  }
}

ImageF Smooth(const ImageViewF& image) {
  ImageF smooth(image.width, image.height);
  for (int y = 0; y < image.height; ++y) SmoothRow(image, y, smooth.row(y));
  return smooth;
}

}  // namespace prism
