// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_to_plenoptic.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include <glog/logging.h>
#include <opencv2/core.hpp>

#include "prism/base/normal_variates.h"
#include "prism/base/random.h"
#include "prism/camera/projection.h"
#include "prism/io/rgbd_kernel.h"

namespace prism {
namespace {

ImageViewF ViewOf(const cv::Mat& image, int width) {
  return {image.ptr<float>(), width, image.rows, static_cast<std::ptrdiff_t>(image.step1())};
}

// 1/z, 0 where there is no measurement beyond the focal length; rows with kRgbdRowPadding zeros.
cv::Mat InverseDepthOf(const cv::Mat& depth_m, double focal_length) {
  cv::Mat inverse, result(depth_m.rows, depth_m.cols + kRgbdRowPadding, CV_32FC1, cv::Scalar(0));
  cv::divide(1, depth_m, inverse);
  inverse.copyTo(result.colRange(0, depth_m.cols), depth_m > focal_length);
  return result;
}

// Fills holes (0) from about the nearest measurement by a chamfer distance transform. (OpenCV's
// with labels takes several times as long, since it also works where nothing is missing.)
class HoleFiller {
 public:
  // `image`: of `width` columns and some more beside them.
  HoleFiller(cv::Mat* image, int width)
      : image_(*image), distances_(image->rows + 2, width + 2, CV_32SC1, cv::Scalar(kFar)) {
    const cv::Mat is_hole = image_.colRange(0, width) == 0;  // 255: true
    is_hole.convertTo(
        distances_({1, 1, width, image_.rows}), CV_32S, static_cast<double>(kFar) / 255);
    for (int y = 0; y < image_.rows; ++y) FindHoles(is_hole.ptr<uchar>(y), y, width);
  }

  // A pass down takes what lies above or to the left, one up what lies below or to the right.
  void Fill() {
    for (const Hole& hole : holes_) FillFrom(-1, hole, hole.begin, hole.end);
    for (auto hole = holes_.rbegin(); hole != holes_.rend(); ++hole) {
      FillFrom(1, *hole, hole->end - 1, hole->begin - 1);
    }
  }

 private:
  static constexpr int kFar = 255 << 20, kStraight = 5, kDiagonal = 7;
  struct Hole {
    int y, begin, end;
  };

  int* Distances(int y) { return distances_.ptr<int>(y + 1) + 1; }

  void FindHoles(const uchar* is_hole, int y, int width) {
    const auto find = [&](int from, int value) {
      const void* found = std::memchr(is_hole + from, value, static_cast<size_t>(width - from));
      return found ? static_cast<int>(static_cast<const uchar*>(found) - is_hole) : width;
    };
    for (int begin = find(0, 255); begin < width;) {
      const int end = find(begin, 0);
      holes_.push_back({y, begin, end});
      begin = find(end, 255);
    }
  }

  // Pixels from `first` on to the one before `last`, from their neighbours at `side`.
  void FillFrom(int side, const Hole& hole, int first, int last) {
    int* distance = Distances(hole.y);
    const int* beside = Distances(hole.y + side);
    float* value = image_.ptr<float>(hole.y);
    const float* value_beside = value + side * static_cast<std::ptrdiff_t>(image_.step1());
    for (int x = first; x != last; x -= side) {
      int nearest = distance[x];
      const float* from = value + x;
      const auto take = [&](int candidate, const float* its_value) {
        from = candidate < nearest ? its_value : from;
        nearest = std::min(nearest, candidate);
      };
      take(distance[x + side] + kStraight, value + x + side);
      take(beside[x] + kStraight, value_beside + x);
      take(beside[x - 1] + kDiagonal, value_beside + x - 1);
      take(beside[x + 1] + kDiagonal, value_beside + x + 1);
      distance[x] = nearest;
      value[x] = *from;
    }
  }

  cv::Mat image_;
  cv::Mat distances_;        // with a border of one pixel that is far
  std::vector<Hole> holes_;  // in the order of reading, each in a row
};

// As float, with a border of kRgbdBorder pixels that repeat the sides.
cv::Mat WithBorder(const cv::Mat& gray) {
  cv::Mat bordered, result;
  cv::copyMakeBorder(
      gray, bordered, kRgbdBorder, kRgbdBorder, kRgbdBorder, kRgbdBorder, cv::BORDER_REPLICATE);
  bordered.convertTo(result, CV_32F);
  return result;
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
  const int width = gray.cols, height = gray.rows;

  const cv::Mat inverse_depth = InverseDepthOf(depth_m, projection.f);
  cv::Mat filled = inverse_depth.clone();
  HoleFiller(&filled, width).Fill();
  const cv::Mat bordered = WithBorder(gray);
  ImageViewF source = ViewOf(bordered, width);
  source.height = height;
  source.data += kRgbdBorder * source.stride + kRgbdBorder;

  LightFieldFrame frame;
  frame.time_ns = time_ns;
  frame.inverse_virtual_depth = ImageF(width, height);
  frame.sigma = ImageF(width, height);
  ImageF image(width, height);
  const float noise_sigma = static_cast<float>(options.inverse_depth_sigma);
  const float stated_sigma =
      static_cast<float>(std::max(options.inverse_depth_sigma, options.min_stated_sigma));
  NormalVariates variates(SeededGenerator(options.seed, stream));
  const size_t row_size = static_cast<size_t>(width) + kRgbdRowPadding;
  std::vector<float> px(row_size), py(row_size), noise(row_size), w(row_size), values(row_size);
  for (int y = 0; y < height; ++y) {
    FindPinholePositions(projection, ViewOf(filled, width), y, px.data(), py.data());
    variates.Fill(noise.data(), static_cast<size_t>(width));
    MeasureInverseVirtualDepth(projection,
                               ViewOf(inverse_depth, width),
                               static_cast<float>(options.edge_ratio),
                               px.data(),
                               py.data(),
                               noise.data(),
                               noise_sigma,
                               w.data());
    ResampleRow(source, px.data(), py.data(), values.data());
    std::copy_n(w.data(), width, frame.inverse_virtual_depth.row(y));
    std::copy_n(values.data(), width, image.row(y));
    float* sigma = frame.sigma.row(y);
    for (int x = 0; x < width; ++x) sigma[x] = w[static_cast<size_t>(x)] > 0 ? stated_sigma : 0;
  }
  frame.image = BuildPyramid(std::move(image), options.pyramid_levels);
  return frame;
}

}  // namespace prism
