// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core/mat.hpp>

#include "prism/image/image.h"
#include "prism/image/pyramid.h"

namespace prism {

// One frame as the camera delivers it.
struct RawFrame {
  int64_t time_ns = 0;
  std::string path;  // for messages
  cv::Mat image;     // 8 or 16 bits, 1 channel (gray or Bayer) or 3 (BGR), as decoded
};

// LightFieldFrame::depth_correlation_px where depth was found in micro images: patches of raw
// pixels overlap, and neighbours are fused. Measured on rendered frames of a Raytrix R5, with one
// focal length and with three (docs/depth.md).
inline constexpr double kMicroImageDepthCorrelation = 5.5;

// What the odometry works on: the totally focused image and the inverse virtual depth on its grid.
struct LightFieldFrame {
  int64_t time_ns = 0;
  ImagePyramid image;  // gray, 0 to 255, level 0 the focused grid
  cv::Mat colour;      // level 0 in colour, BGR, 8 bits; empty: not known
  // Of a window without measured depths both may be empty.
  ImageF inverse_virtual_depth;  // 1/v on the focused grid; 0 = no measurement
  ImageF sigma;                  // standard deviation of 1/v; 0 = no measurement
  // Errors of 1/v at two pixels at distance d correlate by exp(-d^2 / (2 c^2)); c in focused px.
  // 0: they are independent.
  double depth_correlation_px = 0;
};

}  // namespace prism
