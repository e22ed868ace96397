// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/texture.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

Rgb Bilinear(const cv::Mat& image, float u, float v) {
  const float x = (u - std::floor(u)) * static_cast<float>(image.cols) - 0.5f;
  const float y = (v - std::floor(v)) * static_cast<float>(image.rows) - 0.5f;
  const float floor_x = std::floor(x);
  const float floor_y = std::floor(y);
  const float fx = x - floor_x;
  const float fy = y - floor_y;
  const auto wrap = [](int i, int size) { return i < 0 ? i + size : (i >= size ? i - size : i); };
  const int x0 = wrap(static_cast<int>(floor_x), image.cols);
  const int x1 = wrap(x0 + 1, image.cols);
  const cv::Vec4b* row0 = image.ptr<cv::Vec4b>(wrap(static_cast<int>(floor_y), image.rows));
  const cv::Vec4b* row1 = image.ptr<cv::Vec4b>(wrap(static_cast<int>(floor_y) + 1, image.rows));
  const float w00 = (1 - fx) * (1 - fy) / 255;
  const float w10 = fx * (1 - fy) / 255;
  const float w01 = (1 - fx) * fy / 255;
  const float w11 = fx * fy / 255;
  const auto channel = [&](int c) {
    return w00 * row0[x0][c] + w10 * row0[x1][c] + w01 * row1[x0][c] + w11 * row1[x1][c];
  };
  return {channel(2), channel(1), channel(0)};
}

}  // namespace

Texture::Texture(const cv::Mat& image) {
  CHECK(!image.empty());
  CHECK_EQ(image.depth(), CV_8U);
  cv::Mat level;
  cv::cvtColor(image, level, image.channels() == 1 ? cv::COLOR_GRAY2BGRA : cv::COLOR_BGR2BGRA);
  levels_.push_back(level);
  while (std::min(level.cols, level.rows) >= 2) {
    cv::Mat half;
    cv::resize(level, half, cv::Size(level.cols / 2, level.rows / 2), 0, 0, cv::INTER_AREA);
    levels_.push_back(half);
    level = half;
  }
}

Rgb Texture::Sample(float u, float v, float footprint) const {
  const float texels = std::max(footprint * static_cast<float>(levels_[0].cols), 1.0f);
  const float level = std::min(std::log2(texels), static_cast<float>(levels_.size() - 1));
  const auto fine = static_cast<size_t>(level);
  const float to_coarse = level - static_cast<float>(fine);
  Rgb value = Bilinear(levels_[fine], u, v);
  if (to_coarse == 0) return value;
  return (1 - to_coarse) * value + to_coarse * Bilinear(levels_[fine + 1], u, v);
}

}  // namespace prism
