// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/raw_texture.h"

#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

PreparedRaw Noisy(double sigma, float step_at_right) {
  constexpr int kSize = 128;
  PreparedRaw raw;
  raw.gray = ImageF(kSize, kSize);
  raw.lens_colour = Image<uint8_t>(kSize, kSize, 1);
  std::mt19937_64 generator = SeededGenerator(5, 0);
  std::normal_distribution<float> noise(0, static_cast<float>(sigma));
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      raw.gray(x, y) = 100 + noise(generator) + (x >= kSize / 2 ? step_at_right : 0);
    }
  }
  return raw;
}

TEST(RawTexture, NoiseIsMeasured) {
  for (const double sigma : {1.0, 3.0}) {
    RawTexture texture;
    texture.Measure(Noisy(sigma, 0), 3);
    EXPECT_NEAR(texture.noise(), sigma, 0.07 * sigma);
  }
}

TEST(RawTexture, NoiseOfAMosaicIsTakenAsItIs) {
  PreparedRaw raw = Noisy(1, 0);
  raw.mosaic_noise = 2.5;
  RawTexture texture;
  texture.Measure(raw, 3);
  EXPECT_EQ(texture.noise(), 2.5);
}

TEST(RawTexture, AnEdgeIsTextureAndNoiseIsNot) {
  RawTexture texture;
  texture.Measure(Noisy(2, 60), 3);
  EXPECT_GE(texture.CountAround(63, 60), 12);
  EXPECT_LE(texture.CountAround(30, 60), 2);
  EXPECT_GE(texture.CountAround(63, 0), 8);
  EXPECT_EQ(texture.CountAround(127, 127), 0);
}

}  // namespace
}  // namespace prism
