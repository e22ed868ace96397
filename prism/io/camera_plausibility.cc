// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/camera_plausibility.h"

#include <cmath>

#include "prism/base/error.h"
#include "prism/base/format.h"

namespace prism {
namespace {

// An interval that a figure has to be in, with what it may be instead.
struct Range {
  double min, max;
  const char* unit;
  const char* hint;  // empty: none
};

void Require(const std::string& path, const char* name, double value, const Range& range) {
  if (value >= range.min && value <= range.max) return;
  throw InputError(path,
                   std::string(name) + Format(" of %g%s", value, range.unit),
                   Format("%g to %g%s%s", range.min, range.max, range.unit, range.hint));
}

void RequireInside(const std::string& path, const char* name, double value, int size) {
  Require(path,
          name,
          value,
          {-0.5, size - 0.5, " px", ", which is in the image (file of another image size?)"});
}

}  // namespace

void RequirePlausibleCamera(const PlenopticCamera& camera, const std::string& path) {
  Require(path,
          "a pixel size",
          1e3 * camera.raw_pixel_size,
          {3e-4, 0.1, " mm", " (lengths are in mm)"});
  Require(
      path, "a focal length", 1e3 * camera.focal_length, {1, 2000, " mm", " (lengths are in mm)"});
  RequireInside(path, "a principal point x", camera.raw_principal_point.x(), camera.raw_width);
  RequireInside(path, "a principal point y", camera.raw_principal_point.y(), camera.raw_height);
  const double diagonal = camera.raw_pixel_size * std::hypot(camera.raw_width, camera.raw_height);
  const double plane =
      camera.main_lens_mla_distance + 2 * camera.virtual_depth_sign() * camera.sensor_mla_distance;
  Require(path,
          "a field of view",
          2 * std::atan2(diagonal / 2, plane) * 180 / M_PI,
          {5, 120, " degrees", " (from pixel size, image size and main lens to MLA)"});
  if (!camera.micro_lens_grid) return;
  RequirePlausibleGrid(*camera.micro_lens_grid, path);
  const double pitch = camera.micro_lens_grid->diameter_px * camera.raw_pixel_size;
  Require(path,
          "a distance from sensor to MLA",
          camera.sensor_mla_distance / pitch,
          {0.5, 30, " micro-lens pitches", ""});
}

void RequirePlausiblePinhole(const PinholeCamera& camera, const std::string& path) {
  RequireInside(path, "a principal point cx", camera.cx, camera.width);
  RequireInside(path, "a principal point cy", camera.cy, camera.height);
  Require(path,
          "a field of view",
          2 * std::atan(std::hypot(camera.width, camera.height) / (2 * camera.fx)) * 180 / M_PI,
          {5, 170, " degrees", " (from image size and fx)"});
}

void RequirePlausibleInfinity(const PlenopticCamera& camera, const std::string& path) {
  Require(path,
          "a virtual depth of infinity, (f_L - b_L0) / B,",
          (camera.focal_length - camera.main_lens_mla_distance) * camera.virtual_depth_sign() /
              camera.sensor_mla_distance,
          {1.2, 20, "", ""});
}

void RequirePlausibleGrid(const MicroLensGrid& grid, const std::string& path) {
  constexpr double kLargestImage = 65535;
  Require(path, "a micro-image diameter", grid.diameter_px, {4, 1000, " px", ""});
  Require(path, "a grid rotation", grid.rotation, {-7, 7, " rad", ""});
  for (const double offset : {grid.offset_px.x(), grid.offset_px.y()}) {
    Require(path, "a grid offset", offset, {-kLargestImage, kLargestImage, " px", ""});
  }
  Require(path,
          "a lens border",
          grid.lens_border_px,
          {0, grid.diameter_px / 2, " px", ", at most half a micro image"});
  Require(path, "a total covering plane", grid.total_covering_plane, {0, 1000, "", ""});
  for (const Eigen::Vector2d& base : {grid.base_x, grid.base_y}) {
    Require(path, "a base vector's length", base.norm(), {0.3, 3, " diameters", ""});
  }
  for (const MicroLensType& type : grid.types) {
    Require(path, "a lens type's offset", type.offset.norm(), {0, 10, " diameters", ""});
    Require(path, "a smallest virtual depth", type.min_virtual_depth, {0, 1e6, "", ""});
    Require(path,
            "a largest virtual depth",
            type.max_virtual_depth,
            {type.min_virtual_depth, 1e9, "", ", above the smallest"});
  }
}

}  // namespace prism
