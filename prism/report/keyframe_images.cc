// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/keyframe_images.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/base/statistics.h"

namespace prism {
namespace {

constexpr int kJpegQuality = 80;

std::string Encode(const char* extension, const cv::Mat& image, const std::vector<int>& options) {
  std::vector<unsigned char> bytes;
  CHECK(cv::imencode(extension, image, bytes, options));
  return std::string(bytes.begin(), bytes.end());
}

ReportMap MakeMap(const ImageF& values, const ImageF& sigma) {
  std::vector<double> measured;
  for (size_t i = 0; i < values.size(); ++i) {
    if (sigma.data()[i] > 0) measured.push_back(values.data()[i]);
  }
  if (measured.empty()) return {};
  ReportMap map;
  map.low = Quantile(measured, 0.02);
  map.high = Quantile(measured, 0.98);
  const double steps = ReportMap::kLevels - 1;
  const double scale = map.high > map.low ? steps / (map.high - map.low) : 0;
  cv::Mat levels(values.height(), values.width(), CV_8UC1, cv::Scalar(0));
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      if (!(sigma(x, y) > 0)) continue;
      const double level = std::clamp((values(x, y) - map.low) * scale, 0.0, steps);
      levels.at<uint8_t>(y, x) = static_cast<uint8_t>(1 + std::lround(level));
    }
  }
  map.png = Encode(".png", levels, {cv::IMWRITE_PNG_COMPRESSION, 9});
  return map;
}

}  // namespace

void ReportKeyframe::DropPictures() {
  *this = ReportKeyframe{time_ns, world_from_cam, {}, 0, 0, {}, {}, {}};
}

size_t ReportKeyframe::PictureBytes() const {
  return jpeg.size() + points.size() * sizeof(Point) + inverse_virtual_depth.png.size() +
         sigma.png.size();
}

double ThumbnailFactor(int image_width, int max_width) {
  CHECK_GT(max_width, 0);
  double factor = 1;
  while (image_width * factor > max_width) factor *= 0.5;
  return factor;
}

cv::Mat MakeThumbnail(ImageView<float> image, const cv::Mat& colour, int max_width) {
  CHECK_GT(image.width, 0);
  cv::Mat thumbnail = colour;
  if (colour.empty()) {
    const cv::Mat source(image.height,
                         image.width,
                         CV_32FC1,
                         const_cast<float*>(image.data),
                         static_cast<size_t>(image.stride) * sizeof(float));
    source.convertTo(thumbnail, CV_8U);
  }
  const double factor = ThumbnailFactor(image.width, max_width);
  if (factor == 1) return thumbnail;
  cv::Mat small;
  const cv::Size size(std::max(1, static_cast<int>(image.width * factor)),
                      std::max(1, static_cast<int>(image.height * factor)));
  cv::resize(thumbnail, small, size, 0, 0, cv::INTER_AREA);
  return small;
}

void SetThumbnail(const cv::Mat& thumbnail, ReportKeyframe* keyframe) {
  keyframe->jpeg = Encode(".jpg", thumbnail, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  keyframe->width = thumbnail.cols;
  keyframe->height = thumbnail.rows;
}

SmallDepth MakeSmallDepth(ImageView<float> inverse_virtual_depth,
                          ImageView<float> sigma,
                          int max_width) {
  const int block = static_cast<int>(std::lround(1 / ThumbnailFactor(sigma.width, max_width)));
  const int width = std::max(1, sigma.width / block), height = std::max(1, sigma.height / block);
  SmallDepth small{ImageF(width, height, 0), ImageF(width, height, 0)};
  for (int y = 0; y < std::min(height * block, sigma.height); ++y) {
    for (int x = 0; x < width * block; ++x) {
      const float sigma_here = sigma(x, y);
      float& least = small.sigma(x / block, y / block);
      if (!(sigma_here > 0) || (least > 0 && least <= sigma_here)) continue;
      least = sigma_here;
      small.inverse_virtual_depth(x / block, y / block) = inverse_virtual_depth(x, y);
    }
  }
  return small;
}

void SetDepthMaps(const SmallDepth& depth, ReportKeyframe* keyframe) {
  keyframe->inverse_virtual_depth = MakeMap(depth.inverse_virtual_depth, depth.sigma);
  keyframe->sigma = MakeMap(depth.sigma, depth.sigma);
}

}  // namespace prism
