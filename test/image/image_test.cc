// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "prism/image/interpolation.h"
#include "prism/image/noise.h"
#include "prism/image/pyramid.h"
#include "prism/image/smoothing.h"

namespace prism {
namespace {

ImageF RandomImage(int width, int height) {
  std::mt19937_64 generator = SeededGenerator(9, 0);
  std::uniform_real_distribution<float> uniform(0, 255);
  ImageF image(width, height);
  for (size_t i = 0; i < image.size(); ++i) image.data()[i] = uniform(generator);
  return image;
}

TEST(InterpolateBilinear, ReproducesPixelsAndBilinearFunctionsExactly) {
  ImageF image(6, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 6; ++x) image(x, y) = 3.0f + 2.0f * x - y + 0.5f * x * y;
  }
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {5.0, 4.0}, {2.25, 3.5}, {4.75, 0.125}}) {
    const InterpolatedValue sample = InterpolateBilinear(image, x, y);
    EXPECT_FLOAT_EQ(sample.value, 3 + 2 * x - y + 0.5 * x * y);
    EXPECT_FLOAT_EQ(sample.dx, 2 + 0.5 * y);
    EXPECT_FLOAT_EQ(sample.dy, -1 + 0.5 * x);
  }
}

TEST(InterpolateBilinear, GradientIsTheDerivativeOfTheInterpolant) {
  const ImageF image = RandomImage(20, 20);
  std::mt19937_64 generator = SeededGenerator(10, 0);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  std::uniform_int_distribution<int> cell(0, 18);
  for (int i = 0; i < 200; ++i) {
    const double x = cell(generator) + uniform(generator);
    const double y = cell(generator) + uniform(generator);
    const double h = 0.05;  // linear inside the cell along each axis: any step inside it is exact
    const InterpolatedValue sample = InterpolateBilinear(image, x, y);
    const double dx =
        (InterpolateBilinear(image, x + h, y).value - InterpolateBilinear(image, x - h, y).value) /
        (2 * h);
    const double dy =
        (InterpolateBilinear(image, x, y + h).value - InterpolateBilinear(image, x, y - h).value) /
        (2 * h);
    EXPECT_NEAR(sample.dx, dx, 2e-3);
    EXPECT_NEAR(sample.dy, dy, 2e-3);
  }
}

TEST(Pyramid, LevelCoordinatesFollowThePixelCentreRule) {
  ImageF ramp(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) ramp(x, y) = static_cast<float>(x + 10 * y);
  }
  const ImagePyramid pyramid = BuildPyramid(ramp, 3, 8);
  ASSERT_EQ(pyramid.size(), 3u);
  for (int y = 0; y < pyramid[2].height(); ++y) {
    for (int x = 0; x < pyramid[2].width(); ++x) {
      const double x0 = (x + 0.5) * 4 - 0.5, y0 = (y + 0.5) * 4 - 0.5;
      EXPECT_FLOAT_EQ(pyramid[2](x, y), x0 + 10 * y0);
    }
  }
}

TEST(Pyramid, StopsBeforeASideFallsBelowTheMinimum) {
  EXPECT_EQ(BuildPyramid(ImageF(640, 480), 10, 30).size(), 5u);
  EXPECT_EQ(BuildPyramid(ImageF(20, 20), 10, 30).size(), 1u);
}

TEST(SquaredGradientMagnitude, OfARampIsItsSlopeSquared) {
  ImageF ramp(10, 10);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) ramp(x, y) = static_cast<float>(3 * x + 4 * y);
  }
  const ImageF squared = SquaredGradientMagnitude(ramp);
  EXPECT_FLOAT_EQ(squared(5, 5), 25);
  EXPECT_FLOAT_EQ(squared(0, 5), 0);
}

// Variance of interpolated white noise at the pixels over that in the middle between four of them.
double NoiseLostBetweenPixels(const ImageF& image) {
  double at_pixels = 0, between = 0;
  for (int y = 2; y + 3 < image.height(); ++y) {
    for (int x = 2; x + 3 < image.width(); ++x) {
      at_pixels += std::pow(InterpolateBilinear(image, x, y).value, 2);
      between += std::pow(InterpolateBilinear(image, x + 0.5, y + 0.5).value, 2);
    }
  }
  return at_pixels / between;
}

TEST(Smooth, KeepsNoiseNearlyTheSameBetweenPixels) {
  std::mt19937_64 generator = SeededGenerator(12, 0);
  std::normal_distribution<float> normal;
  ImageF noise(300, 300);
  for (size_t i = 0; i < noise.size(); ++i) noise.data()[i] = normal(generator);
  const ImageF smooth = Smooth(noise);
  EXPECT_NEAR(NoiseLostBetweenPixels(noise), 4, 0.2);
  EXPECT_NEAR(NoiseLostBetweenPixels(smooth), 1.44, 0.1);
  double square = 0;
  for (size_t i = 0; i < smooth.size(); ++i) square += std::pow(smooth.data()[i], 2);
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(smooth.size())), kSmoothedNoise, 0.01);
}

TEST(Smooth, LeavesASlopeAsItIs) {
  ImageF slope(20, 10);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 20; ++x) slope(x, y) = 5.0f * x + 2.0f * y;
  }
  const ImageF smooth = Smooth(slope);
  for (int y = 1; y < 9; ++y) {
    for (int x = 0; x < 20; ++x) EXPECT_FLOAT_EQ(smooth(x, y), slope(x, y));
  }
}

TEST(EstimateImageNoise, FindsTheNoiseUnderATexture) {
  std::mt19937_64 generator = SeededGenerator(11, 0);
  for (const float sigma : {1.0f, 4.0f}) {
    std::normal_distribution<float> noise(0, sigma);
    ImageF image(200, 200);
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) {
        image(x, y) = 128 + 50 * std::sin(0.1f * x) * std::cos(0.07f * y) + noise(generator);
      }
    }
    EXPECT_NEAR(EstimateImageNoise(image), sigma, 0.1 * sigma);
  }
}

TEST(EstimateImageNoise, IsZeroWhereEverythingIsClipped) {
  EXPECT_EQ(EstimateImageNoise(ImageF(50, 50, 255.0f)), 0);
}

}  // namespace
}  // namespace prism
