// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/scene/frame.h"

namespace prism {

struct RgbdConversionOptions {
  // Standard deviation of the Gaussian noise added to the measured inverse virtual depth, which is
  // what a real plenoptic camera delivers (0.1 px over one to two micro-lens diameters). 0: clean.
  double inverse_depth_sigma = 0.004;
  // The sigma stated for every measurement is never below this (clean depth is still quantised).
  double min_stated_sigma = 0.0005;
  // Neighbouring inverse depths farther apart than this fraction are an edge: not interpolated.
  double edge_ratio = 0.05;
  uint64_t seed = 0;
  int pyramid_levels = 6;
};

// Turns a pinhole image with registered metric depth into the plenoptic frame that shows the same
// scene, by undoing supplement Section F: pinhole pixel x_p with depth z has
// b_L = (1/f_L - 1/z)^-1, v = (b_L - b_L0) / B and x'_V = (x_p - c) b_L / (b_L0 + 2B) + c.
// The image is resampled onto the focused grid (cubic) with the true depth, holes of the depth map
// filled from the nearest measurement; measurements get noise and are not filled.
//
// `camera` is PlenopticFromPinhole of the image's pinhole camera. `gray` is 8-bit gray, `depth_m`
// 32-bit float metres with 0 = no measurement, both of the camera's size. `stream` numbers the
// frame for the noise generator.
LightFieldFrame PlenopticFrameFromRgbd(const PlenopticCamera& camera,
                                       const cv::Mat& gray,
                                       const cv::Mat& depth_m,
                                       int64_t time_ns,
                                       uint64_t stream,
                                       const RgbdConversionOptions& options);

}  // namespace prism
