// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/geometry/se3.h"

namespace prism {

// A view that can be found again: what is kept of a keyframe that has left the window. Pixels are
// focused px of level 0.
struct Place {
  struct Point {
    float x = 0;
    float y = 0;
    float rho = 0;        // 1/m
    float rho_sigma = 0;  // its standard deviation; 0: known exactly
  };
  struct Feature {
    float x = 0;
    float y = 0;
    float rho = 0;  // 1/m as measured there; 0: it is not known
  };

  int keyframe_id = 0;
  std::vector<uint8_t> image;  // gray, 8 bits, encoded (JPEG)
  std::vector<Point> points;   // frames are aligned to
  float median_rho = 0;        // of them, 1/m
  std::vector<Feature> features;
  cv::Mat descriptors;  // ORB, 32 bytes; a row a feature
};

// A place with its pose, apart from the run it comes from.
struct MappedPlace {
  Place place;
  int64_t time_ns = 0;
  SE3 cam_from_world;
};

}  // namespace prism
