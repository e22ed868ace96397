// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/image/pyramid.h"

#include <algorithm>
#include <utility>

namespace prism {

ImageF HalveImage(const ImageViewF& image) {
  CHECK_GE(image.width, 2);
  CHECK_GE(image.height, 2);
  ImageF half(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height(); ++y) {
    const float* top = image.row(2 * y);
    const float* bottom = image.row(2 * y + 1);
    float* out = half.row(y);
    for (int x = 0; x < half.width(); ++x) {
      out[x] = 0.25f * (top[2 * x] + top[2 * x + 1] + bottom[2 * x] + bottom[2 * x + 1]);
    }
  }
  return half;
}

ImagePyramid BuildPyramid(ImageF image, int max_levels, int min_side) {
  CHECK_GE(max_levels, 1);
  ImagePyramid pyramid;
  pyramid.push_back(std::move(image));
  while (static_cast<int>(pyramid.size()) < max_levels &&
         std::min(pyramid.back().width(), pyramid.back().height()) / 2 >= std::max(min_side, 1)) {
    pyramid.push_back(HalveImage(pyramid.back()));
  }
  return pyramid;
}

ImageF SquaredGradientMagnitude(const ImageViewF& image) {
  ImageF squared(image.width, image.height, 0.0f);
  for (int y = 1; y + 1 < image.height; ++y) {
    const float* above = image.row(y - 1);
    const float* here = image.row(y);
    const float* below = image.row(y + 1);
    float* out = squared.row(y);
    for (int x = 1; x + 1 < image.width; ++x) {
      const float dx = 0.5f * (here[x + 1] - here[x - 1]);
      const float dy = 0.5f * (below[x] - above[x]);
      out[x] = dx * dx + dy * dy;
    }
  }
  return squared;
}

}  // namespace prism
