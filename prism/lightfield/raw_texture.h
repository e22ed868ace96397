// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "prism/lightfield/preparation.h"

namespace prism {

// Noise of a raw frame, and where there is more than that.
class RawTexture {
 public:
  // `min_gradient`: of pixels that count as texture, in standard deviations of the noise of
  // SmoothRows::smooth.
  void Measure(const PreparedRaw& raw, double min_gradient);

  // Standard deviation of the noise of PreparedRaw::gray, 0 to 255, at least 0.3: of the mosaic
  // where there is one (PreparedRaw::mosaic_noise), else by what the filter takes away.
  double noise() const { return noise_; }
  // Number of pixels with texture in a square of some 12 raw px around a position in raw px.
  int CountAround(float x, float y) const;

 private:
  void MeasureNoise(const PreparedRaw& raw);

  double noise_ = 1;
  int width_ = 0, height_ = 0;     // blocks
  std::vector<uint8_t> textured_;  // pixels of each block
};

}  // namespace prism
