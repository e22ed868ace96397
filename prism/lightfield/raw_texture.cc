// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/raw_texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/parallel_for.h>

#include "prism/lightfield/smooth_rows.h"

namespace prism {
namespace {

constexpr int kBlock = 4;  // raw px a side

}  // namespace

void RawTexture::MeasureNoise(const PreparedRaw& raw) {
  // gray - smooth of white noise has 0.8 of its standard deviation; the median absolute value of a
  // Gaussian is 0.6745 of it.
  std::array<int, 1024> histogram{};
  int total = 0;
  std::vector<float> smooth(raw.gray.width());
  for (int y = 1; y < raw.gray.height() - 1; y += 5) {
    FilterWholePixels(raw.gray, y, y + 1, smooth.data());
    for (int x = 1; x < raw.gray.width() - 1; ++x) {
      if (raw.lens_colour(x, y) == 0) continue;
      const float difference = std::abs(raw.gray(x, y) - smooth[x]);
      if (difference == 0) continue;  // not filtered
      ++histogram[std::min(static_cast<int>(difference * 32), 1023)];
      ++total;
    }
  }
  int bin = 0;
  for (int seen = histogram[0]; bin < 1023 && 2 * seen < total; seen += histogram[++bin]) {
  }
  const double noise = raw.mosaic_noise > 0 ? raw.mosaic_noise : (bin + 0.5) / 32 / (0.8 * 0.6745);
  noise_ = std::max(noise, 0.3);
}

void RawTexture::Measure(const PreparedRaw& raw, double min_gradient) {
  MeasureNoise(raw);
  const int width = raw.gray.width();
  const int height = raw.gray.height();
  width_ = (width + kBlock - 1) / kBlock;
  height_ = (height + kBlock - 1) / kBlock;
  textured_.resize(static_cast<size_t>(width_) * height_);
  const float threshold = static_cast<float>(min_gradient * noise_ * kSmoothNoise);
  const float threshold_squared = threshold * threshold;
  std::fill(textured_.begin(), textured_.end(), uint8_t{0});
  constexpr int kRowsAtOnce = 8 * kBlock;  // share what is filtered
  tbb::parallel_for(0, (height + kRowsAtOnce - 1) / kRowsAtOnce, [&](int part) {
    const int first = part * kRowsAtOnce;
    const int last = std::min(first + kRowsAtOnce, height - 1);
    ImageF smooth(width, kRowsAtOnce + 1);
    FilterWholePixels(raw.gray, first, last + 1, smooth.data());
    for (int y = first; y < last; ++y) {
      const float* row = smooth.row(y - first);
      const float* below = smooth.row(y + 1 - first);
      uint8_t* blocks = &textured_[static_cast<size_t>(y / kBlock) * width_];
      const uint8_t* colour = raw.lens_colour.row(y);
      for (int bx = 0; bx < width_; ++bx) {
        int count = 0;
        for (int x = bx * kBlock; x < std::min((bx + 1) * kBlock, width - 1); ++x) {
          const float dx = row[x + 1] - row[x];
          const float dy = below[x] - row[x];
          count += static_cast<int>(colour[x] != 0) &
                   static_cast<int>(dx * dx + dy * dy > threshold_squared);
        }
        blocks[bx] = static_cast<uint8_t>(blocks[bx] + count);
      }
    }
  });
}

int RawTexture::CountAround(float x, float y) const {
  const int bx = static_cast<int>(x) / kBlock;
  const int by = static_cast<int>(y) / kBlock;
  int count = 0;
  for (int v = std::max(by - 1, 0); v <= std::min(by + 1, height_ - 1); ++v) {
    for (int u = std::max(bx - 1, 0); u <= std::min(bx + 1, width_ - 1); ++u) {
      count += textured_[static_cast<size_t>(v) * width_ + u];
    }
  }
  return count;
}

}  // namespace prism
