// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/colour_mosaic.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

constexpr double kNoise = 2;

// A textured raw frame as a sensor with these four colours (gains, row by row) sees it.
cv::Mat RawFrameOf(const double (&gains)[4], double contrast = 1, bool vignetting = true) {
  const auto texture = [&](double X, double Y) {
    return 120 + contrast * (WavyTexture(X, Y) - 120);
  };
  cv::Mat raw = RenderPlane(SmallCamera(), 0.3, texture, 0, vignetting);
  cv::Mat noise(raw.size(), CV_32F);
  cv::RNG(3).fill(noise, cv::RNG::NORMAL, 0, kNoise);
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      raw.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(
          gains[2 * (y % 2) + x % 2] * raw.at<uint8_t>(y, x) + noise.at<float>(y, x));
    }
  }
  return raw;
}

TEST(ColourMosaic, TellsWhereTheGreenPixelsAre) {
  EXPECT_EQ(FindMosaic(RawFrameOf({1, 1, 1, 1})), Mosaic::kNone);
  EXPECT_EQ(FindMosaic(RawFrameOf({1, 0.7, 0.5, 1})), Mosaic::kGreenOnMainDiagonal);
  EXPECT_EQ(FindMosaic(RawFrameOf({0.7, 1, 1, 0.5})), Mosaic::kGreenOnOtherDiagonal);
  EXPECT_EQ(FindMosaic(RawFrameOf({0.7, 1, 1, 0.7})), Mosaic::kGreenOnUnknownDiagonal);
  cv::Mat deep;
  RawFrameOf({0.7, 1, 1, 0.5}).convertTo(deep, CV_16U, 257);
  EXPECT_EQ(FindMosaic(deep), Mosaic::kGreenOnOtherDiagonal);
}

TEST(ColourMosaic, ItsNoiseIsThatOfPixelsOfOneColour) {
  const cv::Mat gain(320, 320, CV_32F, cv::Scalar(1));
  const cv::Mat raw = RawFrameOf({0.7, 1, 1, 0.5}, 0.02, false);
  EXPECT_NEAR(MosaicNoise(raw, gain), kNoise, 0.1 * kNoise);
  EXPECT_NEAR(MosaicNoise(raw, 2 * gain), 2 * MosaicNoise(raw, gain), 1e-6);
  EXPECT_EQ(MosaicNoise(RawFrameOf({1, 1, 1, 1}), 0 * gain), 0);
}

}  // namespace
}  // namespace prism
