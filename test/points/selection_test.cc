// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/selection.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "prism/image/pyramid.h"

namespace prism {
namespace {

ImageF TexturedHalf(int width, int height) {
  ImageF image(width, height, 100.0f);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width / 2; ++x) {
      image(x, y) = static_cast<float>(128 + 60 * std::sin(0.9 * x) * std::cos(0.7 * y));
    }
  }
  return image;
}

TEST(SelectPoints, SpreadsOverTheTextureAndLeavesTheBlankAlone) {
  const ImageF squared = SquaredGradientMagnitude(TexturedHalf(320, 240));
  const auto everywhere = [](int, int) { return true; };
  const std::vector<Eigen::Vector2i> points = SelectPoints(squared, 400, everywhere, {});
  EXPECT_GT(points.size(), 250u);
  EXPECT_LE(points.size(), 400u);
  int quadrant[2] = {0, 0};
  for (const Eigen::Vector2i& px : points) {
    EXPECT_LE(px.x(), 160);
    ++quadrant[px.y() < 120 ? 0 : 1];
  }
  EXPECT_GT(std::min(quadrant[0], quadrant[1]), static_cast<int>(points.size()) / 3);
}

TEST(SelectPoints, TakesOnlyUsablePixels) {
  const ImageF squared = SquaredGradientMagnitude(TexturedHalf(320, 240));
  const auto odd_rows = [](int, int y) { return y % 2 == 1; };
  const std::vector<Eigen::Vector2i> points = SelectPoints(squared, 200, odd_rows, {});
  ASSERT_FALSE(points.empty());
  for (const Eigen::Vector2i& px : points) EXPECT_EQ(px.y() % 2, 1);
}

TEST(SelectPoints, ABlankImageHasNone) {
  const ImageF squared = SquaredGradientMagnitude(ImageF(320, 240, 50.0f));
  EXPECT_TRUE(SelectPoints(squared, 500, [](int, int) { return true; }, {}).empty());
}

}  // namespace
}  // namespace prism
