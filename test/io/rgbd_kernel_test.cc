// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_kernel.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "prism/io/camera_file.h"

namespace prism {
namespace {

constexpr int kWidth = 45, kHeight = 30;  // no multiple of a vector
constexpr size_t kRow = kWidth + kRgbdRowPadding;

ImageViewF ViewOf(const cv::Mat& image) {
  return {image.ptr<float>(), kWidth, kHeight, static_cast<std::ptrdiff_t>(image.step1())};
}

PlenopticProjection Camera() {
  const PlenopticCamera lens =
      ReadPlenopticCamera(std::string(PRISM_SOURCE_DIR) + "/calib/raytrix_r5_16mm.yaml");
  return PlenopticProjection(
      PlenopticFromPinhole({kWidth, kHeight, 40, 40, 0.5 * kWidth, 0.5 * kHeight}, lens));
}

TEST(RgbdKernel, ResamplesAsOpenCvDoes) {
  cv::Mat image(kHeight, kWidth, CV_32FC1);
  cv::RNG random(3);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  cv::Mat bordered;
  cv::copyMakeBorder(
      image, bordered, kRgbdBorder, kRgbdBorder, kRgbdBorder, kRgbdBorder, cv::BORDER_REPLICATE);
  ImageViewF view = ViewOf(bordered);
  view.data = bordered.ptr<float>(kRgbdBorder) + kRgbdBorder;
  std::vector<float> px(kRow), py(kRow), values(kRow);
  for (int repeat = 0; repeat < 50; ++repeat) {
    cv::Mat positions(1, kWidth, CV_32FC2), expected;
    for (size_t i = 0; i < kWidth; ++i) {  // some of them outside, some far
      px[i] = random.uniform(-20.0f, kWidth + 20.0f);
      py[i] = random.uniform(-20.0f, kHeight + 20.0f);
      positions.at<cv::Point2f>(0, static_cast<int>(i)) = {px[i], py[i]};
    }
    cv::remap(image, expected, positions, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    ResampleRow(view, px.data(), py.data(), values.data());
    for (int i = 0; i < kWidth; ++i) {
      ASSERT_NEAR(values[static_cast<size_t>(i)], expected.at<float>(0, i), 2e-3) << i;
    }
  }
}

TEST(RgbdKernel, PositionsFitTheDepthsThatStandThere) {
  const PlenopticProjection camera = Camera();
  cv::Mat filled(kHeight, static_cast<int>(kRow), CV_32FC1);
  for (int x = 0; x < filled.cols; ++x) filled.col(x).setTo(1 / (1 + 0.02 * x));
  std::vector<float> px(kRow), py(kRow);
  for (int y = 0; y < kHeight; ++y) {
    FindPinholePositions(camera, ViewOf(filled), y, px.data(), py.data());
    for (int x = 0; x < kWidth; ++x) {
      const double rho = 1 / (1 + 0.02 * px[static_cast<size_t>(x)]);
      const double b_L = 1 / (1 / camera.f - rho);
      const double scale = (camera.b_L0 + 2 * camera.B) / b_L;  // Eq. (88)
      EXPECT_NEAR(px[static_cast<size_t>(x)], camera.c.x() + scale * (x - camera.c.x()), 0.02);
      EXPECT_NEAR(py[static_cast<size_t>(x)], camera.c.y() + scale * (y - camera.c.y()), 0.02);
    }
  }
}

class MeasuredRow : public testing::Test {
 protected:
  // Measured at (x, 10.25) for x = 0.25, 1.25, ...
  std::vector<float> Measure(float sigma = 0) {
    std::vector<float> px(kRow), py(kRow, 10.25f), noise(kRow, 1.0f), w(kRow);
    for (size_t i = 0; i < kRow; ++i) px[i] = static_cast<float>(i) + 0.25f;
    MeasureInverseVirtualDepth(camera_,
                               ViewOf(inverse_depth_),
                               0.05f,
                               px.data(),
                               py.data(),
                               noise.data(),
                               sigma,
                               w.data());
    return w;
  }

  const PlenopticProjection camera_ = Camera();
  cv::Mat inverse_depth_{kHeight, static_cast<int>(kRow), CV_32FC1, cv::Scalar(0.5)};
};

TEST_F(MeasuredRow, IsInterpolatedOnASurface) {
  for (int x = 0; x < inverse_depth_.cols; ++x) inverse_depth_.col(x).setTo(0.5 + 0.001 * x);
  const std::vector<float> w = Measure(), noisy = Measure(0.004f);
  for (size_t i = 0; i + 1 < kWidth; ++i) {
    const double rho = 0.5 + 0.001 * (static_cast<double>(i) + 0.25);
    EXPECT_NEAR(w[i], InverseVirtualDepth(camera_, rho), 1e-6) << i;
    EXPECT_NEAR(noisy[i] - w[i], 0.004, 1e-6) << i;
  }
  EXPECT_EQ(w[kWidth - 1], 0) << "there is nothing behind the last column";
}

TEST_F(MeasuredRow, IsTheNearestAtAnEdgeAndNothingInAHole) {
  inverse_depth_.colRange(20, inverse_depth_.cols).setTo(0.7);
  inverse_depth_.col(30).setTo(0);
  const std::vector<float> w = Measure();
  EXPECT_NEAR(w[19], InverseVirtualDepth(camera_, 0.5), 1e-6);
  EXPECT_NEAR(w[20], InverseVirtualDepth(camera_, 0.7), 1e-6);
  EXPECT_NEAR(w[29], InverseVirtualDepth(camera_, 0.7), 1e-6);
  EXPECT_EQ(w[30], 0);
}

}  // namespace
}  // namespace prism
