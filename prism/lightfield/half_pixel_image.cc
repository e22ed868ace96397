// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/half_pixel_image.h"

#include <algorithm>
#include <vector>

#include <tbb/parallel_for.h>

namespace prism {
namespace {

// Filters n values, of which the one before and the two behind can be read.
void FilterWhole(const float* in, int n, float* out) {
  for (int x = 0; x < n; ++x) out[x] = 0.25f * (in[x - 1] + in[x + 1]) + 0.5f * in[x];
}
void FilterHalf(const float* in, int n, float* out) {
  for (int x = 0; x < n; ++x) {
    out[x] = 0.0625f * (in[x - 1] + in[x + 2]) + 0.4375f * (in[x] + in[x + 1]);
  }
}

}  // namespace

void HalfPixelImage::Resize(int width, int height) {
  for (auto& row : phase) {
    for (ImageF& image : row) {
      if (image.width() != width || image.height() != height) image = ImageF(width, height);
    }
  }
}

HalfPixelImage::Cell HalfPixelImage::At(float x, float y) const {
  const int column = static_cast<int>(kStepsPerPixel * x);
  const int row = static_cast<int>(kStepsPerPixel * y);
  const auto corner = [&](int u, int v) {
    return phase[v % kStepsPerPixel][u % kStepsPerPixel].row(v / kStepsPerPixel) +
           u / kStepsPerPixel;
  };
  return {{corner(column, row),
           corner(column + 1, row),
           corner(column, row + 1),
           corner(column + 1, row + 1)},
          kStepsPerPixel * x - static_cast<float>(column),
          kStepsPerPixel * y - static_cast<float>(row)};
}

void FilterHalfPixels(const ImageF& image, HalfPixelImage* filtered) {
  const int width = image.width();
  const int height = image.height();
  filtered->Resize(width, height);
  constexpr int kRowsAtOnce = 16;  // share the buffer
  tbb::parallel_for(0, (height + kRowsAtOnce - 1) / kRowsAtOnce, [&](int band) {
    std::vector<float> buffer(static_cast<size_t>(width) + 3);
    float* column_filtered = buffer.data() + 1;
    const auto finish_row = [&](ImageF* rows, int y) {
      column_filtered[-1] = column_filtered[0];
      column_filtered[width] = column_filtered[width + 1] = column_filtered[width - 1];
      FilterWhole(column_filtered, width, rows[0].row(y));
      FilterHalf(column_filtered, width, rows[1].row(y));
    };
    for (int y = band * kRowsAtOnce; y < std::min((band + 1) * kRowsAtOnce, height); ++y) {
      const float* above = image.row(std::max(y - 1, 0));
      const float* here = image.row(y);
      const float* below = image.row(std::min(y + 1, height - 1));
      const float* second = image.row(std::min(y + 2, height - 1));
      for (int x = 0; x < width; ++x) {
        column_filtered[x] = 0.25f * (above[x] + below[x]) + 0.5f * here[x];
      }
      finish_row(filtered->phase[0], y);
      for (int x = 0; x < width; ++x) {
        column_filtered[x] = 0.0625f * (above[x] + second[x]) + 0.4375f * (here[x] + below[x]);
      }
      finish_row(filtered->phase[1], y);
    }
  });
}

}  // namespace prism
