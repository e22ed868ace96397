// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/chief_rays.h"

#include <algorithm>

#include <glog/logging.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/camera/projection.h"
#include "prism/lightfield/dense_depth.h"

namespace prism {
namespace {

cv::Mat ViewOf(const ImageF& image) {
  return {image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data())};
}

ImageF Resample(const ImageF& image, const cv::Mat& at, int interpolation, int border) {
  ImageF result(image.width(), image.height());
  cv::Mat view = ViewOf(result);
  cv::remap(ViewOf(image), view, at, cv::noArray(), interpolation, border);
  return result;
}

// b_L / f_L of the depths that the frame's image was rendered with.
ImageF VirtualScale(const PlenopticProjection& projection, const LightFieldFrame& frame) {
  constexpr double kNearest = 0.05, kFarthest = 0.5;  // 1/v of what is infinitely far, within
  const double far = InverseVirtualDepthAtInfinity(projection);
  ImageF scale;
  DenseDepth().Fill(frame.inverse_virtual_depth,
                    frame.sigma,
                    static_cast<float>(std::clamp(far, kNearest, kFarthest)),
                    &scale);
  for (size_t i = 0; i < scale.size(); ++i) {
    scale.data()[i] =
        static_cast<float>((projection.b_L0 + projection.B / scale.data()[i]) / projection.f);
  }
  return scale;
}

// The pixel of the image of virtual points that shows the chief ray of each pixel.
cv::Mat FindVirtualPoints(const PlenopticProjection& projection, const ImageF& scale) {
  constexpr int kIterations = 5;  // converges by a factor of |d scale / dx| r, about 0.1
  const auto c = projection.c.cast<float>();
  cv::Mat at(scale.height(), scale.width(), CV_32FC2);
  for (int y = 0; y < at.rows; ++y) {
    for (int x = 0; x < at.cols; ++x) {
      at.at<cv::Vec2f>(y, x) = {static_cast<float>(x), static_cast<float>(y)};
    }
  }
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const ImageF there = Resample(scale, at, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    for (int y = 0; y < at.rows; ++y) {
      for (int x = 0; x < at.cols; ++x) {
        const float k = there(x, y);
        at.at<cv::Vec2f>(y, x) = {k * (static_cast<float>(x) - c.x()) + c.x(),
                                  k * (static_cast<float>(y) - c.y()) + c.y()};
      }
    }
  }
  return at;
}

}  // namespace

LightFieldFrame ToChiefRays(const PlenopticCamera& camera, const LightFieldFrame& frame) {
  CHECK(camera.focused_image == FocusedImage::kVirtualPoints);
  const PlenopticProjection projection(camera);
  const cv::Mat at = FindVirtualPoints(projection, VirtualScale(projection, frame));
  LightFieldFrame result = frame;
  const auto move_depth = [&](const ImageF& map) {
    return Resample(map, at, cv::INTER_NEAREST, cv::BORDER_CONSTANT);
  };
  result.inverse_virtual_depth = move_depth(frame.inverse_virtual_depth);
  result.sigma = move_depth(frame.sigma);
  result.image = BuildPyramid(Resample(frame.image[0], at, cv::INTER_CUBIC, cv::BORDER_REPLICATE),
                              static_cast<int>(frame.image.size()));
  if (!frame.colour.empty()) {
    result.colour = cv::Mat();  // not the one that is shared with `frame`
    cv::remap(
        frame.colour, result.colour, at, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  }
  return result;
}

}  // namespace prism
