// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/smooth_rows.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

ImageF RandomImage(int width, int height) {
  ImageF image(width, height);
  std::mt19937_64 generator = SeededGenerator(6, 0);
  std::uniform_real_distribution<float> gray(0, 255);
  std::generate_n(image.data(), image.size(), [&] { return gray(generator); });
  return image;
}

void ExpectSameRows(
    const HalfPixelImage& some, const HalfPixelImage& all, int begin, int end, int rows_together) {
  for (int j = 0; j < HalfPixelImage::kStepsPerPixel; ++j) {
    for (int i = 0; i < HalfPixelImage::kStepsPerPixel; ++i) {
      for (int y = begin; y < end; ++y) {
        // As a patch reads them, from its first row on.
        const int together = std::min(rows_together, end - y);
        const size_t n = static_cast<size_t>(together) * static_cast<size_t>(all.width());
        ASSERT_TRUE(std::equal(some.row(j, i, y), some.row(j, i, y) + n, all.row(j, i, y)))
            << "phase " << i << ", " << j << ", row " << y << " of " << begin << " to " << end;
      }
    }
  }
}

TEST(SmoothRows, AWindowHoldsTheRowsOfTheWholeImage) {
  constexpr int kWidth = 30, kHeight = 100, kRoom = 23;
  const ImageF image = RandomImage(kWidth, kHeight);
  SmoothRows all(kWidth, kHeight, kHeight, true), some(kWidth, kHeight, kRoom, true);
  SmoothRows once(kWidth, kHeight, kRoom, false);
  all.Begin(image);
  all.MoveTo(0, kHeight);
  for (int pass = 0; pass < 2; ++pass) {
    some.Begin(image);
    once.Begin(image);
    // Down the image by steps of all sizes, back a little, and with rows left out.
    for (const auto& [begin, end] : {std::pair(-3, 12),
                                     {5, 13},
                                     {10, 33},
                                     {12, 30},
                                     {16, 39},
                                     {38, 60},
                                     {62, 85},
                                     {40, 50},
                                     {77, 100},
                                     {90, 104}}) {
      const int first = std::max(begin, 0), last = std::min(end, kHeight);
      some.MoveTo(begin, end);
      once.MoveTo(begin, end);
      EXPECT_TRUE(some.Holds(first, last));
      EXPECT_TRUE(once.Holds(first, last));
      EXPECT_FALSE(some.Holds(first, first + kRoom + 1));
      ExpectSameRows(some.smooth(), all.smooth(), first, last, HalfPixelImage::kRowsTogether);
      ExpectSameRows(some.smoother(), all.smoother(), first, last, HalfPixelImage::kRowsTogether);
      ExpectSameRows(once.smooth(), all.smooth(), first, last, HalfPixelImage::kRowsTogether);
    }
  }
}

TEST(SmoothRows, WholePixelsAreThoseFilteredAlone) {
  const ImageF image = RandomImage(30, 20);
  const HalfPixelImage half = FilterHalfPixels(image);
  const ImageF whole = FilterWholePixels(image);
  for (int y = 0; y < image.height(); ++y) {
    EXPECT_TRUE(std::equal(whole.row(y), whole.row(y) + whole.width(), half.row(0, 0, y))) << y;
  }
}

}  // namespace
}  // namespace prism
