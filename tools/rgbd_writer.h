// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "prism/camera/plenoptic_camera.h"
#include "prism/lightfield/pinhole_view.h"

namespace prism {

// Writes pinhole views as a TUM RGB-D folder: rgb/, depth/ (16 bits, 1/5000 m, 0 = none or beyond
// 13.1 m), rgb.txt, depth.txt, associations.txt and calibration.txt (fx fy cx cy width height).
// Throws InputError if a file cannot be written.
class RgbdWriter {
 public:
  // Views are cropped to `crop_fov_deg`, 0: not.
  RgbdWriter(const std::string& folder, const PinholeCamera& camera, double crop_fov_deg);
  void Write(int64_t time_ns, const PinholeFrame& frame);
  void Finish();

 private:
  std::string folder_;
  PinholeCamera camera_;
  int left_ = 0;
  int top_ = 0;
  int count_ = 0;
  std::string rgb_list_, depth_list_, associations_;
};

}  // namespace prism
