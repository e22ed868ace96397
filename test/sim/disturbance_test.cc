// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/disturbance.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "prism/base/random.h"

namespace prism {
namespace {

TEST(Disturbance, ExposureScalesAndClips) {
  cv::Mat image = (cv::Mat_<uint8_t>(1, 3) << 10, 100, 200);
  ScaleExposure(2, &image);
  EXPECT_EQ(image.at<uint8_t>(0), 20);
  EXPECT_EQ(image.at<uint8_t>(1), 200);
  EXPECT_EQ(image.at<uint8_t>(2), 255);
  EXPECT_EQ(image.type(), CV_8UC1);
}

TEST(Disturbance, TheSheetHidesTheLeftHalfAndItsDepth) {
  cv::Mat image(40, 60, CV_32F, cv::Scalar(7)), depth(40, 60, CV_16U, cv::Scalar(5000));
  std::mt19937_64 generator = SeededGenerator(1, 0);
  CoverHalf(&generator, &image, &depth);
  cv::Scalar mean, deviation;
  cv::meanStdDev(image.colRange(0, 30), mean, deviation);
  EXPECT_NEAR(mean[0], 120, 1);
  EXPECT_LT(deviation[0], 4);
  EXPECT_EQ(cv::countNonZero(depth.colRange(0, 30)), 0);
  EXPECT_EQ(cv::countNonZero(image.colRange(30, 60) != 7), 0);
  EXPECT_EQ(cv::countNonZero(depth.colRange(30, 60)), 30 * 40);
}

TEST(Disturbance, ThePatchCoversAFifthKeepsItsTextureAndMoves) {
  const auto place = [](int frame, cv::Mat* patch) {
    cv::Mat image(300, 400, CV_32F, cv::Scalar(-1)), depth(300, 400, CV_16U, cv::Scalar(1));
    PasteMovingPatch({5000}, frame, &image, &depth);
    cv::Mat points;
    cv::findNonZero(depth == 5000, points);
    cv::Rect place;
    for (int i = 0; i < static_cast<int>(points.total()); ++i) {
      const cv::Rect pixel(points.at<cv::Point>(i), cv::Size(1, 1));
      place = i == 0 ? pixel : place | pixel;
    }
    EXPECT_NEAR(place.area() / (300.0 * 400), 0.2, 0.005);
    image(place).copyTo(*patch);
    return place.tl();
  };
  cv::Mat first, later;
  const cv::Point start = place(0, &first), end = place(20, &later);
  EXPECT_GT(std::hypot(end.x - start.x, end.y - start.y), 50);
  EXPECT_EQ(cv::norm(first, later, cv::NORM_INF), 0);
}

TEST(Disturbance, AsManyDepthsAreSpoiledAsAskedFor) {
  cv::Mat depth(100, 100, CV_16U, cv::Scalar(10000));
  std::mt19937_64 generator = SeededGenerator(2, 0);
  SpoilDepth(0.3, &generator, &depth);
  EXPECT_NEAR(cv::countNonZero(depth != 10000), 3000, 200);
  double least, most;
  cv::minMaxLoc(depth, &least, &most);
  EXPECT_GE(least, 2990);
  EXPECT_LE(most, 30010);
}

}  // namespace
}  // namespace prism
