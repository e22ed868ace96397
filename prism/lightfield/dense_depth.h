// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// Fills the gaps between measurements by pull and push over a pyramid: each level holds the mean of
// its four children weighted by 1/sigma^2, and a gap takes the bilinear value of the level above.
// Measured pixels stay as they are. All pixels become `fallback` if there is no measurement.
// Buffers are kept between calls.
class DenseDepth {
 public:
  void Fill(const ImageF& inverse_virtual_depth,
            const ImageF& sigma,
            float fallback,
            ImageF* dense);

 private:
  struct Level {
    ImageF value, weight;
  };
  std::vector<Level> levels_;  // levels_[0] is half the size
};

}  // namespace prism
