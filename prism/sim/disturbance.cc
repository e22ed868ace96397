// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/disturbance.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

// Smoothed noise of two wavelengths, so that it has texture on every level of a pyramid.
cv::Mat PatchTexture(unsigned seed, const cv::Size& size) {
  cv::RNG random(seed + 1);
  cv::Mat texture = cv::Mat::zeros(size, CV_32F);
  for (const double sigma : {1.5, 6.0}) {
    cv::Mat layer(size, CV_32F);
    random.fill(layer, cv::RNG::NORMAL, 0, 1);
    cv::GaussianBlur(layer, layer, {}, sigma);
    cv::Scalar mean, deviation;
    cv::meanStdDev(layer, mean, deviation);
    texture += (layer - mean) * (25 / deviation[0]);
  }
  return texture + 128;
}

// Something uniform before a part of the view.
void PutSheet(const cv::Rect& part,
              float gray,
              float noise,
              std::mt19937_64* generator,
              cv::Mat* image,
              cv::Mat* depth) {
  cv::Mat sheet(part.size(), CV_32F);
  std::normal_distribution<float> normal(gray, noise);
  for (int y = 0; y < sheet.rows; ++y) {
    for (int x = 0; x < sheet.cols; ++x) sheet.at<float>(y, x) = normal(*generator);
  }
  sheet.convertTo((*image)(part), image->type());
  (*depth)(part).setTo(0);
}

}  // namespace

void ScaleExposure(double gain, cv::Mat* image) {
  cv::Mat scaled;
  image->convertTo(scaled, CV_32F, gain);
  cv::min(scaled, 255, scaled);
  scaled.convertTo(*image, image->type());
}

void CoverHalf(std::mt19937_64* generator, cv::Mat* image, cv::Mat* depth) {
  constexpr float kGray = 120, kNoise = 2;
  PutSheet(cv::Rect(0, 0, image->cols / 2, image->rows), kGray, kNoise, generator, image, depth);
}

void CoverLens(std::mt19937_64* generator, cv::Mat* image, cv::Mat* depth) {
  constexpr float kGray = 3, kNoise = 1;
  PutSheet(cv::Rect(0, 0, image->cols, image->rows), kGray, kNoise, generator, image, depth);
}

void PasteMovingPatch(const MovingPatch& patch, int frame, cv::Mat* image, cv::Mat* depth) {
  const double side = std::sqrt(0.2);
  const cv::Size size(static_cast<int>(side * image->cols), static_cast<int>(side * image->rows));
  const double phase = 2 * M_PI * frame / patch.period;
  const cv::Point corner(
      static_cast<int>((0.5 - 0.5 * std::cos(phase)) * (image->cols - size.width)),
      static_cast<int>((0.5 - 0.25 * std::sin(phase)) * (image->rows - size.height)));
  const cv::Rect place(corner, size);
  PatchTexture(patch.seed, size).convertTo((*image)(place), image->type());
  (*depth)(place).setTo(patch.depth);
}

void SpoilDepth(double fraction, std::mt19937_64* generator, cv::Mat* depth) {
  cv::Mat value;
  depth->convertTo(value, CV_32F);
  std::uniform_real_distribution<double> uniform;
  for (int y = 0; y < value.rows; ++y) {
    for (int x = 0; x < value.cols; ++x) {
      if (uniform(*generator) >= fraction) continue;
      value.at<float>(y, x) *= static_cast<float>(0.3 * std::pow(10.0, uniform(*generator)));
    }
  }
  value.convertTo(*depth, depth->type());
}

}  // namespace prism
