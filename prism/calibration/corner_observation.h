// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prism/board/calibration_board.h"

namespace prism {

// A corner of the board in one picture, in terms that do not depend on what is to be calibrated.
//
// Around a place of the raw image, the micro image with centre c_I shows a virtual point at
//   x_raw(c_I) = (1 - m) x_0 + m c_I                                 (Eqs. (6) to (8), raw px)
// where x_0 is where the ray through the main lens' centre meets the sensor (there the point is in
// the middle of a micro image), and the slope m = (1 - 1/v) b_L0 / (b_L0 + B) its virtual depth. A
// smooth distortion moves x_0 and leaves m. Whoever measures x'_V and v with some camera knows x_0
// and m without having to trust it.
struct CornerObservation {
  int corner = 0;                                            // of the board
  Eigen::Vector2d micro_image_px = Eigen::Vector2d::Zero();  // c_I, raw px
  Eigen::Vector2d px = Eigen::Vector2d::Zero();              // x_raw(c_I), raw px
  double px_sigma = 0;                                       // of each coordinate
  double slope = 0;                                          // m
  double slope_sigma = 0;                                    // errors of px and slope: independent

  // x_0, distorted raw px.
  Eigen::Vector2d ChiefPx() const { return (px - slope * micro_image_px) / (1 - slope); }
};

// One picture of the board.
struct BoardView {
  std::string name;  // for messages: the picture's file
  std::vector<CornerObservation> corners;
};

// Mean of the corners of a view, on the board. Precondition: the view has corners.
inline Eigen::Vector3d MiddleOfCorners(const CalibrationBoard& board, const BoardView& view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const CornerObservation& corner : view.corners) sum += board.CornerPosition(corner.corner);
  return sum / static_cast<double>(view.corners.size());
}

}  // namespace prism
