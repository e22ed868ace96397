// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace prism {

// One of up to three kinds of micro lenses of a multi-focus array, in use where it is sharp.
struct MicroLensType {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  // in diameters, y up: one lens of this type
  double min_virtual_depth = 1;                      // v
  double max_virtual_depth = 100;                    // v

  // 1/v the type is focused on: the middle, in 1/v, of its range as far as it is above v = 2.
  double FocusInverseVirtualDepth() const {
    return 0.5 * (std::min(0.5, 1 / min_virtual_depth) + 1 / max_virtual_depth);
  }
};

// Axial index (i, j) of a lens on the lattice.
struct LensIndex {
  int i = 0;
  int j = 0;
  bool operator==(const LensIndex& other) const { return i == other.i && j == other.j; }
};

// The lattice of micro images on the raw sensor, hexagonal or square by its base vectors, in the
// terms of Raytrix' RayCalibData:
// raw px, **y up**, from the image centre ((W - 1) / 2, (H - 1) / 2).
//
//   p = offset + Rotation(rotation) (i base_x + j base_y) diameter,
//   raw_px = ((W - 1) / 2 + p.x, (H - 1) / 2 - p.y).
struct MicroLensGrid {
  double diameter_px = 0;  // pitch of the micro images
  double rotation = 0;     // radians, counter-clockwise with y up; what the base vectors lack
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d base_x = {1, 0};                         // in diameters
  Eigen::Vector2d base_y = {0.5, 0.86602540378443864676};  // in diameters
  double lens_border_px = 1;                               // dark rim of a micro image
  double total_covering_plane = 2;  // v at which micro images cover the plane without gaps
  std::vector<MicroLensType> types = {MicroLensType{}};

  bool IsValid(std::string* error) const;

  // Centre of a micro image in raw px (y down) of an image of the given size.
  Eigen::Vector2d MicroImageCenter(const LensIndex& lens, int raw_width, int raw_height) const;

  // The lens whose micro image centre is nearest to a raw pixel. O(1).
  LensIndex NearestLens(const Eigen::Vector2d& raw_px, int raw_width, int raw_height) const;

  // Index into `types`, of period three on the lattice for three types.
  int TypeOf(const LensIndex& lens) const;

 private:
  // Columns: base_x and base_y in raw px with y down.
  Eigen::Matrix2d Basis() const;
  Eigen::Vector2d Origin(int raw_width, int raw_height) const;
};

}  // namespace prism
