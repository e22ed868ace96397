// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/pinhole_view.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <tbb/parallel_for.h>
#include <opencv2/core.hpp>

#include "prism/camera/projection.h"
#include "prism/image/interpolation.h"

namespace prism {
namespace {

// Bilinear, within the image.
cv::Vec3b InterpolateColour(const cv::Mat& image, const Eigen::Vector2d& px) {
  const int x = std::min(static_cast<int>(px.x()), image.cols - 2);
  const int y = std::min(static_cast<int>(px.y()), image.rows - 2);
  const double fx = px.x() - x;
  const double fy = px.y() - y;
  const auto at = [&](int u, int v) { return cv::Vec3d(image.at<cv::Vec3b>(v, u)); };
  const cv::Vec3d mean = (1 - fy) * ((1 - fx) * at(x, y) + fx * at(x + 1, y)) +
                         fy * ((1 - fx) * at(x, y + 1) + fx * at(x + 1, y + 1));
  return {cv::saturate_cast<uint8_t>(mean[0]),
          cv::saturate_cast<uint8_t>(mean[1]),
          cv::saturate_cast<uint8_t>(mean[2])};
}

}  // namespace

PinholeFrame MakePinholeView(const PlenopticCamera& camera,
                             const LightFieldFrame& frame,
                             const ImageF& dense_inverse_virtual_depth) {
  const PlenopticProjection projection(camera);
  const ImageF& image = frame.image[0];
  CHECK_EQ(image.width(), projection.width);
  CHECK_EQ(dense_inverse_virtual_depth.size(), image.size());
  PinholeFrame view;
  view.image = ImageF(image.width(), image.height(), 0);
  view.depth = ImageF(image.width(), image.height(), 0);
  if (!frame.colour.empty()) view.colour = cv::Mat(frame.colour.size(), CV_8UC3, cv::Scalar(0));
  tbb::parallel_for(0, image.height(), [&](int y) {
    for (int x = 0; x < image.width(); ++x) {
      Eigen::Vector2d x_V(x, y);
      constexpr int kIterations = 5;  // converges by a factor of |d scale / dx| r, about 0.1
      for (int iteration = 0; iteration < kIterations; ++iteration) {
        const Eigen::Vector2d inside(std::clamp(x_V.x(), 0.0, image.width() - 1.0),
                                     std::clamp(x_V.y(), 0.0, image.height() - 1.0));
        const double w =
            InterpolateBilinear(dense_inverse_virtual_depth, inside.x(), inside.y()).value;
        x_V = VirtualFromPinhole(projection, {x, y}, InverseDepth(projection, w));
      }
      if (!image.view().Contains(x_V.x(), x_V.y())) continue;
      view.image(x, y) = InterpolateBilinear(image, x_V.x(), x_V.y()).value;
      if (!frame.colour.empty()) {
        view.colour.at<cv::Vec3b>(y, x) = InterpolateColour(frame.colour, x_V);
      }
      const float w = frame.inverse_virtual_depth(static_cast<int>(std::lround(x_V.x())),
                                                  static_cast<int>(std::lround(x_V.y())));
      if (w == 0) continue;
      const double rho = InverseDepth(projection, w);
      if (rho > 1e-3) view.depth(x, y) = static_cast<float>(1 / rho);
    }
  });
  return view;
}

PinholeCamera CropToFieldOfView(const PinholeCamera& camera, double fov_deg, int* left, int* top) {
  CHECK_GT(fov_deg, 0);
  CHECK_LT(fov_deg, 180);
  const double half = std::tan(0.5 * fov_deg * M_PI / 180);
  PinholeCamera cropped = camera;
  *left = std::max(static_cast<int>(std::ceil(camera.cx - half * camera.fx)), 0);
  *top = std::max(static_cast<int>(std::ceil(camera.cy - half * camera.fy)), 0);
  const int right =
      std::min(static_cast<int>(std::floor(camera.cx + half * camera.fx)), camera.width - 1);
  const int bottom =
      std::min(static_cast<int>(std::floor(camera.cy + half * camera.fy)), camera.height - 1);
  cropped.width = right - *left + 1;
  cropped.height = bottom - *top + 1;
  cropped.cx -= *left;
  cropped.cy -= *top;
  return cropped;
}

}  // namespace prism
