// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/vignetting.h"

#include <gtest/gtest.h>

#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

std::vector<cv::Mat> Frames(const PlenopticCamera& camera, bool vignetting) {
  std::vector<cv::Mat> frames;
  for (const double w : {0.24, 0.27, 0.31, 0.35}) {
    frames.push_back(RenderPlane(camera, w, WavyTexture, 1.5, vignetting));
  }
  return frames;
}

TEST(EstimateVignetting, FindsTheShadingUnderATexture) {
  const PlenopticCamera camera = SmallCamera(480);
  const LensTable lenses(camera);
  const std::optional<Vignetting> found = EstimateVignetting(lenses, Frames(camera, true));
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->IsNeeded());
  // As a white image without noise shows it, up to a factor.
  const cv::Mat white = RenderPlane(
      camera, 0.3, [](double, double) { return 200; }, 0, true);
  double sum = 0, sum_squared = 0;
  int count = 0;
  for (const Lens& lens : lenses.lenses()) {
    lenses.ForEachPixel(lens, [&](int x, int y) {
      const double ratio =
          found->white.at<uint16_t>(y, x) / static_cast<double>(white.at<uint8_t>(y, x));
      sum += ratio;
      sum_squared += ratio * ratio;
      ++count;
    });
  }
  const double mean = sum / count;
  EXPECT_LT(std::sqrt(sum_squared / count - mean * mean), 0.02 * mean);
}

TEST(EstimateVignetting, EvenMicroImagesNeedNone) {
  const PlenopticCamera camera = SmallCamera(480);
  const std::optional<Vignetting> found =
      EstimateVignetting(LensTable(camera), Frames(camera, false));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->IsNeeded());
  EXPECT_NEAR(found->rim, 1, 0.02);
}

TEST(EstimateVignetting, DarkFramesTellNothing) {
  const PlenopticCamera camera = SmallCamera();
  EXPECT_FALSE(EstimateVignetting(LensTable(camera), {cv::Mat(320, 320, CV_8UC1, cv::Scalar(3))}));
}

}  // namespace
}  // namespace prism
