// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core/mat.hpp>

#include "prism/base/random.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/camera/projection.h"

namespace prism {

// A small camera with the proportions of a Raytrix R5.
inline PlenopticCamera SmallCamera(int size = 320, MicroLensMode mode = MicroLensMode::kGalilean) {
  PlenopticCamera camera;
  camera.mode = mode;
  camera.focal_length = 16.748e-3;
  camera.main_lens_mla_distance = mode == MicroLensMode::kGalilean ? 15.893e-3 : 18.064e-3;
  camera.sensor_mla_distance = 0.376e-3;
  camera.raw_width = camera.raw_height = size;
  camera.raw_pixel_size = 5.5e-6;
  camera.raw_principal_point = {0.5 * size + 3.2, 0.5 * size - 4.1};
  MicroLensGrid grid;
  grid.diameter_px = 23.2023;
  grid.rotation = 0.002;
  grid.offset_px = {0.3, -0.7};
  camera.micro_lens_grid = grid;
  return camera;
}

// Brightness at a point of the virtual image, in undistorted raw px.
using VirtualTexture = std::function<double(double X, double Y)>;

// The same camera with its micro lenses in a square.
inline PlenopticCamera SquareCamera(int size = 320) {
  PlenopticCamera camera = SmallCamera(size);
  camera.micro_lens_grid->base_x = {1, 0};
  camera.micro_lens_grid->base_y = {0, 1};
  return camera;
}

// Names a test by its camera: mode and kind of lattice.
inline std::string CameraName(const ::testing::TestParamInfo<PlenopticCamera>& test) {
  const MicroLensGrid& grid = *test.param.micro_lens_grid;
  const bool is_square = std::abs(grid.base_x.dot(grid.base_y)) < 0.25;
  return std::string(ToString(test.param.mode)) + (is_square ? "_square" : "_hexagonal");
}

inline double WavyTexture(double X, double Y) {
  return 120 + 35 * std::sin(0.17 * X + 0.11 * Y) + 30 * std::sin(0.13 * Y - 0.07 * X + 1) +
         15 * std::sin(0.23 * X - 0.19 * Y);
}

// Fall-off of a micro image towards its rim.
inline double FallOff(double radius_px) { return 1 - 0.4 * radius_px * radius_px / 121; }

// The raw image of a plane that stands at inverse virtual depth `w` in virtual space, by the
// inverse of Eqs. (6)-(7) for each pixel's lens; independent of prism/lightfield.
inline cv::Mat RenderPlane(const PlenopticCamera& camera,
                           double w,
                           const VirtualTexture& texture,
                           double noise = 0,
                           bool vignetting = false) {
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  std::mt19937_64 generator = SeededGenerator(7, 0);
  std::normal_distribution<double> gauss(0, 1);
  cv::Mat raw(camera.raw_height, camera.raw_width, CV_8UC1);
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      const Eigen::Vector2d pixel(x, y);
      const LensIndex lens = grid.NearestLens(pixel, raw.cols, raw.rows);
      const Eigen::Vector2d c_I = grid.MicroImageCenter(lens, raw.cols, raw.rows);
      const Eigen::Vector2d c_ML = MicroLensCenter(camera, c_I);
      const Eigen::Vector2d X = c_ML + (pixel - c_ML) * (camera.virtual_depth_sign() / w);
      double value = texture(X.x(), X.y());
      if (vignetting) value *= FallOff((pixel - c_I).norm());
      value += noise * gauss(generator);
      raw.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  return raw;
}

}  // namespace prism
