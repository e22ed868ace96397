// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/colour_mosaic.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glog/logging.h>

#include "prism/base/statistics.h"

namespace prism {
namespace {

cv::Mat ToFloat(const cv::Mat& image) {
  CHECK_EQ(image.channels(), 1);
  cv::Mat result;
  image.convertTo(result, CV_32F, image.depth() == CV_8U ? 1.0 : 1.0 / 257);
  return result;
}

}  // namespace

Mosaic FindMosaic(const cv::Mat& image) {
  constexpr int kBlock = 16;
  constexpr double kUnlike = 2.5;  // times as different as what should be alike
  const cv::Mat p = ToFloat(image);
  const auto at = [&](int x, int y) { return static_cast<double>(p.at<float>(y, x)); };
  // Second differences: a gradient of the scene is not seen.
  std::vector<double> main_diagonal, other_diagonal, diagonals;
  for (int by = 2; by + kBlock + 2 < p.rows; by += kBlock) {
    for (int bx = 2; bx + kBlock + 2 < p.cols; bx += kBlock) {
      double main = 0, other = 0, between = 0;
      for (int y = by; y < by + kBlock; y += 2) {
        for (int x = bx; x < bx + kBlock; x += 2) {
          main += at(x, y) - 0.5 * (at(x - 1, y - 1) + at(x + 1, y + 1));
          other += at(x + 1, y) - 0.5 * (at(x, y + 1) + at(x + 2, y - 1));
          between += at(x, y) - 0.25 * (at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1)) +
                     at(x + 1, y + 1) -
                     0.25 * (at(x, y + 1) + at(x + 2, y + 1) + at(x + 1, y) + at(x + 1, y + 2));
        }
      }
      main_diagonal.push_back(std::abs(main));
      other_diagonal.push_back(std::abs(other));
      diagonals.push_back(0.5 * std::abs(between));
    }
  }
  if (diagonals.empty()) return Mosaic::kNone;
  const double main = Quantile(main_diagonal, 0.5);
  const double other = Quantile(other_diagonal, 0.5);
  if (other > kUnlike * main) return Mosaic::kGreenOnMainDiagonal;
  if (main > kUnlike * other) return Mosaic::kGreenOnOtherDiagonal;
  const bool is_mosaic = Quantile(diagonals, 0.5) > kUnlike * std::max(main, other);
  return is_mosaic ? Mosaic::kGreenOnUnknownDiagonal : Mosaic::kNone;
}

double MosaicNoise(const cv::Mat& mosaic, const cv::Mat& gain) {
  CHECK_EQ(gain.type(), CV_32F);
  CHECK(gain.size() == mosaic.size());
  constexpr double kGolden = 0.6180339887498949;
  const double step = mosaic.depth() == CV_8U ? 1.0 : 1.0 / 257;
  const cv::Mat p = ToFloat(mosaic);
  std::vector<double> along_x, along_y;
  const auto add = [&](int x, int y, int dx, int dy, std::vector<double>* differences) {
    if (gain.at<float>(y - dy, x - dx) == 0 || gain.at<float>(y + dy, x + dx) == 0) return;
    const float neighbours = p.at<float>(y - dy, x - dx) + p.at<float>(y + dy, x + dx);
    // Differences of whole numbers come in steps of a half; spread over them, so that a quantile is
    // not one of them.
    const double spread = std::fmod(kGolden * static_cast<double>(differences->size()), 1.0) - 0.5;
    const double difference = p.at<float>(y, x) - 0.5 * neighbours + 0.5 * step * spread;
    differences->push_back(std::abs(gain.at<float>(y, x) * difference));
  };
  for (int y = 2; y + 2 < p.rows; y += 5) {
    for (int x = 2; x + 2 < p.cols; ++x) {
      if (gain.at<float>(y, x) == 0) continue;
      add(x, y, 2, 0, &along_x);
      add(x, y, 0, 2, &along_y);
    }
  }
  if (along_x.empty() || along_y.empty()) return 0;
  // A quarter of the absolute values of a Gaussian are below 0.3186 of its standard deviation;
  // texture adds to the others first.
  return std::min(Quantile(along_x, 0.25), Quantile(along_y, 0.25)) / (0.3186 * std::sqrt(1.5));
}

}  // namespace prism
