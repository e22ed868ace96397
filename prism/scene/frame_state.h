// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "prism/geometry/se3.h"

namespace prism {

// What is estimated of a frame, in one block of 9 doubles for Ceres: the pose cam_from_world (7,
// as in SE3) and the affine brightness (a, b) of supplement Eq. (20): a scene point of brightness
// L has intensity e^a L + b in this frame (intensities 0 to 255). Tangent: [translation; rotation;
// a; b] (8).
class FrameState {
 public:
  static constexpr int kSize = 9;
  static constexpr int kTangentSize = 8;

  FrameState() : FrameState(SE3(), 0, 0) {}
  explicit FrameState(const double* values) { std::copy_n(values, kSize, values_.begin()); }
  FrameState(const SE3& cam_from_world, double a, double b) {
    set_pose(cam_from_world);
    values_[7] = a;
    values_[8] = b;
  }

  SE3 pose() const { return SE3(values_.data()); }  // cam_from_world
  double a() const { return values_[7]; }
  double b() const { return values_[8]; }
  void set_pose(const SE3& cam_from_world) {
    for (int i = 0; i < 7; ++i) values_[i] = cam_from_world.data()[i];
  }

  double* data() { return values_.data(); }
  const double* data() const { return values_.data(); }

 private:
  std::array<double, kSize> values_;
};

}  // namespace prism
