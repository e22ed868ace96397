// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/export_run.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/io/focused_sequence.h"

namespace prism {
namespace {

constexpr double kMaxSigma = 0.1;  // at 65535, as in a focused sequence

// Fast rather than small: the run waits for it.
std::vector<uint8_t> EncodePng(const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  CHECK(cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1}));
  return bytes;
}

uint16_t Encode(double fraction) {
  return static_cast<uint16_t>(std::clamp(std::round(65535 * fraction), 1.0, 65535.0));
}

}  // namespace

std::string ExportKeyframe::ImageName() const { return FrameFileName(id); }

void EncodeFrame(const LightFieldFrame& frame, ExportKeyframe* keyframe) {
  const ImageF& image = frame.image[0];
  if (!frame.colour.empty()) {
    keyframe->image = EncodePng(frame.colour);
  } else {
    const cv::Mat view(
        image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data()));  // NOLINT
    cv::Mat gray;
    view.convertTo(gray, CV_8U);
    keyframe->image = EncodePng(gray);
  }
  // Both in one image, 1/v above its sigma.
  const int height = image.height();
  cv::Mat depth(2 * height, image.width(), CV_16UC1, cv::Scalar(0));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (!(frame.sigma(x, y) > 0)) continue;
      depth.at<uint16_t>(y, x) = Encode(1 - frame.inverse_virtual_depth(x, y));
      depth.at<uint16_t>(height + y, x) = Encode(frame.sigma(x, y) / kMaxSigma);
    }
  }
  keyframe->depth = EncodePng(depth);
}

cv::Mat DecodeImage(const ExportKeyframe& keyframe) {
  return cv::imdecode(keyframe.image, cv::IMREAD_UNCHANGED);
}

cv::Mat DecodeGray(const ExportKeyframe& keyframe) {
  return cv::imdecode(keyframe.image, cv::IMREAD_GRAYSCALE);
}

DepthMap DecodeDepth(const ExportKeyframe& keyframe) {
  const cv::Mat encoded = cv::imdecode(keyframe.depth, cv::IMREAD_UNCHANGED);
  const int height = encoded.rows / 2;
  DepthMap map{ImageF(encoded.cols, height, 0), ImageF(encoded.cols, height, 0)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < encoded.cols; ++x) {
      const int value = encoded.at<uint16_t>(y, x);
      if (value == 0) continue;
      map.inverse_virtual_depth(x, y) = static_cast<float>(1 - value / 65535.0);
      map.sigma(x, y) =
          static_cast<float>(kMaxSigma * encoded.at<uint16_t>(height + y, x) / 65535.0);
    }
  }
  return map;
}

SE3 WorldFromPinhole(const PlenopticProjection& camera, const SE3& world_from_cam) {
  return world_from_cam *
         SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, camera.center_z()));
}

}  // namespace prism
