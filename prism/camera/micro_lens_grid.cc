// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/micro_lens_grid.h"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace prism {

bool MicroLensGrid::IsValid(std::string* error) const {
  if (!(std::isfinite(diameter_px) && diameter_px >= 4)) {
    *error = "micro-image diameter of " + std::to_string(diameter_px) + " px, expected 4 or more";
  } else if (!(std::isfinite(rotation) && offset_px.allFinite())) {
    *error = "micro-lens grid with a rotation or offset that is not finite";
  } else if (!(std::abs(base_x.x() * base_y.y() - base_x.y() * base_y.x()) > 0.1)) {
    *error = "micro-lens grid with parallel base vectors";
  } else if (types.size() != 1 && types.size() != 3) {
    *error = std::to_string(types.size()) + " micro-lens types, expected 1 or 3";
  } else {
    return true;
  }
  return false;
}

Eigen::Matrix2d MicroLensGrid::Basis() const {
  Eigen::Matrix2d basis_y_up;
  basis_y_up << base_x, base_y;
  Eigen::Matrix2d basis = Eigen::Rotation2Dd(rotation).toRotationMatrix() * basis_y_up;
  basis.row(1) *= -1;
  return basis * diameter_px;
}

Eigen::Vector2d MicroLensGrid::Origin(int raw_width, int raw_height) const {
  return {0.5 * (raw_width - 1) + offset_px.x(), 0.5 * (raw_height - 1) - offset_px.y()};
}

Eigen::Vector2d MicroLensGrid::MicroImageCenter(const LensIndex& lens,
                                                int raw_width,
                                                int raw_height) const {
  return Origin(raw_width, raw_height) + Basis() * Eigen::Vector2d(lens.i, lens.j);
}

LensIndex MicroLensGrid::NearestLens(const Eigen::Vector2d& raw_px,
                                     int raw_width,
                                     int raw_height) const {
  const Eigen::Matrix2d basis = Basis();
  const Eigen::Vector2d lattice = basis.inverse() * (raw_px - Origin(raw_width, raw_height));
  // The nearest lattice point is a corner of the cell that holds the point, or next to one.
  const int i0 = static_cast<int>(std::floor(lattice.x()));
  const int j0 = static_cast<int>(std::floor(lattice.y()));
  LensIndex nearest;
  double nearest_squared = std::numeric_limits<double>::infinity();
  for (int j = j0; j <= j0 + 1; ++j) {
    for (int i = i0; i <= i0 + 1; ++i) {
      const double squared = (basis * (lattice - Eigen::Vector2d(i, j))).squaredNorm();
      if (squared < nearest_squared) {
        nearest_squared = squared;
        nearest = {i, j};
      }
    }
  }
  return nearest;
}

int MicroLensGrid::TypeOf(const LensIndex& lens) const {
  if (types.size() == 1) return 0;
  // The three-colouring of a hexagonal lattice whose neighbours all differ: with base vectors 60
  // degrees apart it is (i - j) mod 3, with 120 degrees (i + j) mod 3.
  const int sign = base_x.dot(base_y) > 0 ? -1 : 1;
  const auto colour = [sign](int i, int j) { return ((i + sign * j) % 3 + 3) % 3; };
  Eigen::Matrix2d basis;
  basis << base_x, base_y;
  const Eigen::Matrix2d lattice_from_offset = basis.inverse();
  for (int type = 0; type < 3; ++type) {
    const Eigen::Vector2d lattice = lattice_from_offset * types[type].offset;
    const int i = static_cast<int>(std::lround(lattice.x()));
    const int j = static_cast<int>(std::lround(lattice.y()));
    if (colour(i, j) == colour(lens.i, lens.j)) return type;
  }
  return 0;
}

}  // namespace prism
