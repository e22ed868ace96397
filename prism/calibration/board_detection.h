// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "prism/board/calibration_board.h"
#include "prism/image/image.h"

namespace prism {

struct DetectedCorner {
  int corner = 0;  // number on the board
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double spacing_px = 0;  // side of a square around it, the shorter one
};

// Corners of the board in an image (gray, 0 to 255), to a fraction of a pixel: OpenCV's
// detectors, then the edges between squares.
// Of a ChArUco board any part may be seen; a checkerboard has to be seen whole, and which way round
// it is is left open if both its sides are even or both odd. Empty: no board, one of another number
// of squares in a row, or fewer than 6 corners of it.
std::vector<DetectedCorner> DetectBoard(const CalibrationBoard& board, const ImageF& image);

}  // namespace prism
