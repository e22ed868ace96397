// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "prism/camera/distortion.h"
#include "prism/camera/micro_lens_grid.h"

namespace prism {

// Where the main lens' images lie. A virtual depth v > 0 is a distance of v B from the micro lenses
// in either mode.
enum class MicroLensMode {
  kGalilean,   // virtual images behind the micro lenses: b_L = b_L0 + v B; f_L > b_L0
  kKeplerian,  // real images before the micro lenses: b_L = b_L0 - v B; f_L < b_L0
};

const char* ToString(MicroLensMode mode);  // "galilean", "keplerian"

// What a pixel of a totally focused image shows.
enum class FocusedImage {
  // The virtual point at it (Eqs. (10), (12)): where the scene's depth is taken to be another than
  // it is, the image is displaced along the chief ray, by (x - c) f_L times the error of 1/z.
  kVirtualPoints,
  // The chief ray, through the middle of the main lens, that meets the plane of infinitely far
  // points at it. Depth taken wrongly blurs this image, but does not displace it.
  kChiefRays,
};

const char* ToString(FocusedImage image);  // "virtual_points", "chief_rays"
inline constexpr char kFocusedImages[] = "virtual_points or chief_rays";
// False if the name is none of them.
bool ParseFocusedImage(const std::string& name, FocusedImage* image);

// A focused plenoptic camera: thin main lens, pinhole micro lenses (supplement Section B, which is
// written for Galilean cameras). Lengths in metres. Raw pixels and focused pixels are different
// grids: raw = (focused + 0.5) * focused_scale - 0.5.
struct PlenopticCamera {
  MicroLensMode mode = MicroLensMode::kGalilean;
  double focal_length = 0;            // f_L
  double main_lens_mla_distance = 0;  // b_L0
  double sensor_mla_distance = 0;     // B
  int raw_width = 0;
  int raw_height = 0;
  double raw_pixel_size = 0;
  Eigen::Vector2d raw_principal_point = Eigen::Vector2d::Zero();  // c_L in raw px
  int focused_scale = 2;                                          // raw width / focused width
  FocusedImage focused_image = FocusedImage::kVirtualPoints;
  Distortion distortion;
  // Eq. (8) holds between micro-image centres and micro-lens centres (false: they coincide).
  bool adjust_micro_lens_centers = true;
  std::optional<MicroLensGrid> micro_lens_grid;  // only what reads raw frames needs it

  // 1 Galilean, -1 Keplerian. With b_L = b_L0 + sign v B and x_R = (x'_V - c_ML) sign / v + c_ML,
  // Eqs. (2), (4), (6), (7) hold in both modes: a Keplerian camera's micro images are upside down.
  double virtual_depth_sign() const { return mode == MicroLensMode::kKeplerian ? -1 : 1; }

  int focused_width() const { return raw_width / focused_scale; }
  int focused_height() const { return raw_height / focused_scale; }

  // False with a reason ("focal length of -1 m, expected > 0") when a figure makes no sense.
  bool IsValid(std::string* error) const;

  // False with a reason where f_L and b_L0 put nothing real at any virtual depth of this mode: such
  // a camera can measure 1/v, but no metres.
  bool HasMetricDepth(std::string* error) const;
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

// The plenoptic camera with the lenses of `lens` (f_L, b_L0, B, mode) whose pinhole view on the
// plane of v = 2 (supplement Section F: 2B behind the micro-lens array) is `pinhole`: the focused
// pixel size s follows from f_px * s = b_L0 + 2 B; raw and focused grid coincide. Precondition: fx
// = fy (square pixels).
PlenopticCamera PlenopticFromPinhole(const PinholeCamera& pinhole, const PlenopticCamera& lens);

// The pinhole camera of supplement Section F for a plenoptic camera, on its focused grid.
PinholeCamera PinholeView(const PlenopticCamera& camera);

}  // namespace prism
