// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace prism {

// Radial and tangential lens distortion (Brown), in metres about the principal point, applied to
// raw coordinates and micro-image centres:
//   dx = x (A0 r^2 + A1 r^4) + B0 (r^2 + 2 x^2) + 2 B1 x y,
//   dy = y (A0 r^2 + A1 r^4) + B1 (r^2 + 2 y^2) + 2 B0 x y,
//   distorted = undistorted + d(undistorted).
struct Distortion {
  double A0 = 0;  // 1/m^2
  double A1 = 0;  // 1/m^4
  double B0 = 0;  // 1/m
  double B1 = 0;  // 1/m

  bool IsZero() const { return A0 == 0 && A1 == 0 && B0 == 0 && B1 == 0; }

  // Optional J: d distorted / d undistorted.
  Eigen::Vector2d Distort(const Eigen::Vector2d& undistorted, Eigen::Matrix2d* J = nullptr) const;

  // Inverse of Distort by Newton's method, to 1e-14 of the larger coordinate where the map is
  // invertible (all of the sensor for real lenses).
  Eigen::Vector2d Undistort(const Eigen::Vector2d& distorted) const;
};

}  // namespace prism
