// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "prism/camera/distortion.h"
#include "prism/camera/micro_lens_grid.h"

namespace prism {

// A focused plenoptic camera in Galilean mode: thin main lens, pinhole micro lenses (supplement
// Section B). Lengths in metres. Raw pixels and focused pixels are different grids:
// raw = (focused + 0.5) * focused_scale - 0.5.
struct PlenopticCamera {
  double focal_length = 0;            // f_L
  double main_lens_mla_distance = 0;  // b_L0
  double sensor_mla_distance = 0;     // B
  int raw_width = 0;
  int raw_height = 0;
  double raw_pixel_size = 0;
  Eigen::Vector2d raw_principal_point = Eigen::Vector2d::Zero();  // c_L in raw px
  int focused_scale = 2;                                          // raw width / focused width
  Distortion distortion;
  // Eq. (8) holds between micro-image centres and micro-lens centres (false: they coincide).
  bool adjust_micro_lens_centers = true;
  std::optional<MicroLensGrid> micro_lens_grid;  // only what reads raw frames needs it

  int focused_width() const { return raw_width / focused_scale; }
  int focused_height() const { return raw_height / focused_scale; }

  // False with a reason ("focal length of -1 m, expected > 0") when a figure makes no sense.
  bool IsValid(std::string* error) const;
};

// A pinhole camera for RGB-D input, in pixels.
struct PinholeCamera {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;

  bool IsValid(std::string* error) const;
};

// The plenoptic camera with the lenses of `lens` (f_L, b_L0, B) whose pinhole view on the plane 2B
// behind the micro-lens array (supplement Section F) is `pinhole`: the focused pixel size s follows
// from f_px * s = b_L0 + 2 B; raw and focused grid coincide. Precondition: fx = fy (square pixels).
PlenopticCamera PlenopticFromPinhole(const PinholeCamera& pinhole, const PlenopticCamera& lens);

// The pinhole camera of supplement Section F for a plenoptic camera, on its focused grid.
PinholeCamera PinholeView(const PlenopticCamera& camera);

}  // namespace prism
