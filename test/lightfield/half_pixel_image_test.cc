// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/half_pixel_image.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace prism {
namespace {

float Interpolate(const HalfPixelImage& image, float x, float y) {
  const HalfPixelImage::Cell cell = image.At(x, y);
  const float top = *cell.corner[0] + cell.fx * (*cell.corner[1] - *cell.corner[0]);
  const float bottom = *cell.corner[2] + cell.fx * (*cell.corner[3] - *cell.corner[2]);
  return top + cell.fy * (bottom - top);
}

TEST(HalfPixelImage, ARampKeepsItsValues) {
  ImageF ramp(20, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) ramp(x, y) = static_cast<float>(2 * x + 3 * y);
  }
  const HalfPixelImage image = FilterHalfPixels(ramp);
  for (const float x : {5.0f, 5.2f, 5.5f, 5.9f}) {
    for (const float y : {7.0f, 7.4f, 7.5f, 7.7f}) {
      EXPECT_NEAR(Interpolate(image, x, y), 2 * x + 3 * y, 1e-4) << x << " " << y;
    }
  }
}

// What depth depends on: a wave of 4 px is as strong between the pixels as on them. Between
// neighbours a pixel apart it would lose 29 % in the middle.
TEST(HalfPixelImage, AFineWaveIsNearlyAsStrongAtEveryPosition) {
  constexpr int kPhases = 8;
  float weakest = 1, strongest = 0;
  for (int k = 0; k < kPhases; ++k) {
    const float position = 12 + static_cast<float>(k) / kPhases;
    // The wave has its crest at the position that is read.
    ImageF wave(32, 32);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        wave(x, y) = std::cos(static_cast<float>(M_PI) / 2 * (static_cast<float>(x) - position));
      }
    }
    const HalfPixelImage image = FilterHalfPixels(wave);
    const float strength = Interpolate(image, position, 12);
    weakest = std::min(weakest, strength);
    strongest = std::max(strongest, strength);
  }
  EXPECT_NEAR(strongest, 0.53, 0.01);
  EXPECT_GT(weakest, 0.88f * strongest);
}

}  // namespace
}  // namespace prism
