// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_to_plenoptic.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <glog/logging.h>
#include <opencv2/imgproc.hpp>

#include "prism/base/random.h"
#include "prism/camera/projection.h"

namespace prism {
namespace {

// Inverse depth 1/z with holes (0) filled from the nearest measurement. All holes: infinitely far.
cv::Mat FillInverseDepth(const cv::Mat& inverse_depth) {
  const cv::Mat hole = inverse_depth == 0;
  if (cv::countNonZero(hole) == 0) return inverse_depth;
  cv::Mat filled = inverse_depth.clone();
  if (cv::countNonZero(hole) == static_cast<int>(hole.total())) return filled;
  cv::Mat distance, label;
  cv::distanceTransform(hole, distance, label, cv::DIST_L2, 3, cv::DIST_LABEL_PIXEL);
  double max_label;
  cv::minMaxLoc(label, nullptr, &max_label);
  std::vector<float> value_of_label(static_cast<size_t>(max_label) + 1, 0.0f);
  for (int y = 0; y < label.rows; ++y) {
    for (int x = 0; x < label.cols; ++x) {
      const float rho = inverse_depth.at<float>(y, x);
      if (rho != 0) value_of_label[label.at<int>(y, x)] = rho;
    }
  }
  for (int y = 0; y < label.rows; ++y) {
    for (int x = 0; x < label.cols; ++x)
      filled.at<float>(y, x) = value_of_label[label.at<int>(y, x)];
  }
  return filled;
}

// Positions in the pinhole image that focused pixels show: Eq. (88) holds with the depth found
// there, solved by fixed-point iteration (the magnification changes by some per cent only, so that
// three steps reach rounding on a smooth surface). Float arithmetic: this runs for every pixel.
class PinholePositions {
 public:
  PinholePositions(const PlenopticProjection& camera, const cv::Mat& filled)
      : filled_(filled),
        cx_(static_cast<float>(camera.c.x())),
        cy_(static_cast<float>(camera.c.y())),
        full_scale_(static_cast<float>((2 * camera.B + camera.b_L0) / camera.f)),
        f_(static_cast<float>(camera.f)) {}

  cv::Point2f At(int x, int y) const {
    const float dx = static_cast<float>(x) - cx_;
    const float dy = static_cast<float>(y) - cy_;
    int column = x, row = y;
    cv::Point2f position;
    for (int iteration = 0; iteration < 3; ++iteration) {
      const float scale = full_scale_ * (1 - filled_.ptr<float>(row)[column] * f_);
      position = {cx_ + scale * dx, cy_ + scale * dy};
      column = std::clamp(static_cast<int>(position.x + 0.5f), 0, filled_.cols - 1);
      row = std::clamp(static_cast<int>(position.y + 0.5f), 0, filled_.rows - 1);
    }
    return position;
  }

 private:
  const cv::Mat& filled_;
  float cx_, cy_, full_scale_, f_;
};

// Inverse depth measured at a position: interpolated on a smooth surface, the nearest pixel's at an
// edge or beside a hole, 0 where that has none.
float MeasuredInverseDepth(const cv::Mat& inverse_depth, const cv::Point2f& p, double edge_ratio) {
  const int x0 = static_cast<int>(std::floor(p.x));
  const int y0 = static_cast<int>(std::floor(p.y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= inverse_depth.cols || y0 + 1 >= inverse_depth.rows) return 0;
  const float* top = inverse_depth.ptr<float>(y0) + x0;
  const float* bottom = inverse_depth.ptr<float>(y0 + 1) + x0;
  const auto [low, high] = std::minmax({top[0], top[1], bottom[0], bottom[1]});
  const float fx = p.x - static_cast<float>(x0);
  const float fy = p.y - static_cast<float>(y0);
  if (low == 0 || high - low > edge_ratio * high)
    return (fy < 0.5f ? top : bottom)[fx < 0.5f ? 0 : 1];
  return (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) +
         fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
}

ImageF ImageFromMat(const cv::Mat& mat) {
  ImageF image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr<float>(y), mat.cols, image.row(y));
  return image;
}

}  // namespace

LightFieldFrame PlenopticFrameFromRgbd(const PlenopticCamera& camera,
                                       const cv::Mat& gray,
                                       const cv::Mat& depth_m,
                                       int64_t time_ns,
                                       uint64_t stream,
                                       const RgbdConversionOptions& options) {
  const PlenopticProjection projection(camera);
  CHECK_EQ(gray.type(), CV_8UC1);
  CHECK_EQ(depth_m.type(), CV_32FC1);
  CHECK(gray.cols == projection.width && gray.rows == projection.height);
  CHECK(depth_m.size() == gray.size());

  cv::Mat inverse_depth(depth_m.size(), CV_32FC1);
  for (int y = 0; y < depth_m.rows; ++y) {
    for (int x = 0; x < depth_m.cols; ++x) {
      const float z = depth_m.at<float>(y, x);
      inverse_depth.at<float>(y, x) = z > projection.f ? 1 / z : 0;
    }
  }
  const cv::Mat filled = FillInverseDepth(inverse_depth);

  LightFieldFrame frame;
  frame.time_ns = time_ns;
  frame.inverse_virtual_depth = ImageF(gray.cols, gray.rows, 0.0f);
  frame.sigma = ImageF(gray.cols, gray.rows, 0.0f);
  const float stated_sigma =
      static_cast<float>(std::max(options.inverse_depth_sigma, options.min_stated_sigma));
  std::mt19937_64 generator = SeededGenerator(options.seed, stream);
  std::normal_distribution<float> noise(0.0f, 1.0f);
  const PinholePositions pinhole_positions(projection, filled);
  cv::Mat positions(gray.size(), CV_32FC2);
  for (int y = 0; y < gray.rows; ++y) {
    for (int x = 0; x < gray.cols; ++x) {
      const cv::Point2f position = pinhole_positions.At(x, y);
      positions.at<cv::Point2f>(y, x) = position;
      const float rho = MeasuredInverseDepth(inverse_depth, position, options.edge_ratio);
      if (rho == 0) continue;
      double w = InverseVirtualDepth(projection, rho);
      if (options.inverse_depth_sigma > 0) w += options.inverse_depth_sigma * noise(generator);
      if (!(w > 0 && w <= 0.5)) continue;
      frame.inverse_virtual_depth(x, y) = static_cast<float>(w);
      frame.sigma(x, y) = stated_sigma;
    }
  }

  cv::Mat gray_float, focused;
  gray.convertTo(gray_float, CV_32F);
  cv::remap(gray_float, focused, positions, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  frame.image = BuildPyramid(ImageFromMat(focused), options.pyramid_levels);
  return frame;
}

}  // namespace prism
