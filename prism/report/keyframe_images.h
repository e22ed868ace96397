// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/geometry/se3.h"
#include "prism/image/image.h"

namespace prism {

// A quantity over the image of a keyframe, for a page that colours it.
struct ReportMap {
  std::string png;  // gray: 0 where there is none, else 1 to kLevels, from `low` to `high`
  double low = 0;
  double high = 0;
  static constexpr int kLevels = 63;  // more cannot be told apart, and cost bytes
};

struct ReportKeyframe {
  struct Point {
    float x = 0;  // px of the image
    float y = 0;
    float depth_m = 0;
    // RMS over the frames of the window that see it, intensities; NaN: none does.
    float residual = std::numeric_limits<float>::quiet_NaN();
  };
  int64_t time_ns = 0;
  SE3 world_from_cam;
  std::string jpeg;  // the encoded image
  int width = 0;     // px
  int height = 0;
  std::vector<Point> points;
  ReportMap inverse_virtual_depth;  // of the image, maybe on fewer pixels; empty: none
  ReportMap sigma;                  // of 1/v

  // Leaves time and pose.
  void DropPictures();
  size_t PictureBytes() const;
};

// Pixels of the thumbnail over those of the image: the largest power of 1/2 that makes an image of
// this width at most max_width wide.
double ThumbnailFactor(int image_width, int max_width);

// A keyframe's image, gray 0 to 255, or as `colour` (BGR, 8 bits, of the same size) where that is
// not empty, made smaller by ThumbnailFactor.
cv::Mat MakeThumbnail(ImageView<float> image, const cv::Mat& colour, int max_width);

// Sets jpeg, width and height.
void SetThumbnail(const cv::Mat& thumbnail, ReportKeyframe* keyframe);

// 1/v and its sigma on fewer pixels, ThumbnailFactor(width, max_width) of them; each has the
// measurement of least sigma of the pixels it stands for. 0 = no measurement.
struct SmallDepth {
  ImageF inverse_virtual_depth;
  ImageF sigma;
};
SmallDepth MakeSmallDepth(ImageView<float> inverse_virtual_depth,
                          ImageView<float> sigma,
                          int max_width);

// Sets inverse_virtual_depth and sigma of the keyframe, from the 2nd to the 98th percentile; what
// lies outside is shown as these. Nothing measured: both are empty.
void SetDepthMaps(const SmallDepth& depth, ReportKeyframe* keyframe);

}  // namespace prism
