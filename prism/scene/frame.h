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

// What the odometry works on: the totally focused image and the inverse virtual depth on its grid.
struct LightFieldFrame {
  int64_t time_ns = 0;
  ImagePyramid image;            // gray, 0 to 255, level 0 the focused grid
  ImageF inverse_virtual_depth;  // 1/v on the focused grid; 0 = no measurement
  ImageF sigma;                  // standard deviation of 1/v; 0 = no measurement
};

}  // namespace prism
