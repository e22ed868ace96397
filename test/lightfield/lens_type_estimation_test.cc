// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/lens_type_estimation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "prism/lightfield/lens_table.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

// Texture whose edges have no preferred size: its power falls with the square of the frequency.
cv::Mat Texture() {
  constexpr int kSide = 700;
  cv::Mat texture(kSide, kSide, CV_32F, cv::Scalar(0));
  cv::RNG random(5);
  for (int cell = 2; cell <= 128; cell *= 2) {
    cv::Mat coarse(kSide / cell + 2, kSide / cell + 2, CV_32F), fine;
    random.fill(coarse, cv::RNG::NORMAL, 0, 1);
    cv::resize(coarse, fine, {}, cell, cell, cv::INTER_CUBIC);
    texture += fine(cv::Rect(0, 0, kSide, kSide)) * 16;
  }
  return texture + 120;
}

// A plane at 1/v = w as lenses see it that are focused on focus[k], k the lattice.
RawFrame FrameAt(const PlenopticCamera& camera,
                 double w,
                 const std::array<double, 3>& focus,
                 const cv::Mat& texture) {
  const LensTable lenses(camera);
  cv::Mat raws[3];
  for (int k = 0; k < 3; ++k) {
    const double defocus = w - focus[k];
    // From raw px to those of the virtual image; a spot in focus has 0.4 px.
    const double sigma = std::sqrt(lenses.DefocusVariance() * defocus * defocus + 0.16) / w;
    cv::Mat blurred;
    cv::GaussianBlur(texture, blurred, {}, sigma);
    raws[k] = RenderPlane(
        camera,
        w,
        [&](double X, double Y) {
          cv::Mat value;
          cv::getRectSubPix(blurred,
                            {1, 1},
                            cv::Point2f(static_cast<float>(X + 190), static_cast<float>(Y + 190)),
                            value);
          return static_cast<double>(value.at<float>(0, 0));
        },
        1);
  }
  RawFrame frame;
  frame.image = raws[0].clone();
  for (const Lens& lens : lenses.lenses()) {
    lenses.ForEachPixel(lens, [&](int x, int y) {
      frame.image.at<uint8_t>(y, x) = raws[lens.colour].at<uint8_t>(y, x);
    });
  }
  return frame;
}

std::vector<RawFrame> Frames(const PlenopticCamera& camera, const std::array<double, 3>& focus) {
  const cv::Mat texture = Texture();
  std::vector<RawFrame> frames;
  for (const double w : {0.38, 0.2, 0.24, 0.28, 0.33, 0.42}) {
    frames.push_back(FrameAt(camera, w, focus, texture));
  }
  return frames;
}

TEST(LensTypeEstimation, FindsWhichLensIsFocusedOnWhat) {
  const PlenopticCamera camera = SmallCamera();
  for (const std::array<double, 3>& focus :
       {std::array<double, 3>{0.40, 0.30, 0.18}, std::array<double, 3>{0.18, 0.38, 0.29}}) {
    const LensTypeFit fit = EstimateLensTypes(camera, cv::Mat(), {}, Frames(camera, focus));
    ASSERT_EQ(fit.types.size(), 3u);
    EXPECT_TRUE(fit.focus_measured) << fit.focus_sigma;
    PlenopticCamera found = camera;
    found.micro_lens_grid->types = fit.types;
    const LensTable lenses(found);
    for (const Lens& lens : lenses.lenses()) {
      EXPECT_NEAR(lenses.focus_of_type()[lens.type], focus[lens.colour], 0.02)
          << "lattice " << lens.colour << ", known to " << fit.focus_sigma;
    }
  }
}

// A first frame that shows nothing has no depths to tell types by.
TEST(LensTypeEstimation, DoesNotDependOnTheFirstFrameAlone) {
  const PlenopticCamera camera = SmallCamera();
  std::vector<RawFrame> frames = Frames(camera, {0.40, 0.30, 0.18});
  frames[0].image.setTo(128);
  EXPECT_EQ(EstimateLensTypes(camera, cv::Mat(), {}, frames).types.size(), 3u);
}

TEST(LensTypeEstimation, OneTypeIsOneType) {
  const PlenopticCamera camera = SmallCamera();
  const LensTypeFit fit =
      EstimateLensTypes(camera, cv::Mat(), {}, Frames(camera, {0.35, 0.35, 0.35}));
  EXPECT_EQ(fit.types.size(), 1u) << fit.evidence;
}

}  // namespace
}  // namespace prism
