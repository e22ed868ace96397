// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Core>
#include <opencv2/aruco/charuco.hpp>

namespace prism {

enum class BoardPattern {
  kCharuco,       // checkerboard with ArUco markers (DICT_4X4_250) in the white squares
  kCheckerboard,  // squares alone
};

// A flat target of squares; what is observed of it are the corners where four squares meet.
//
// Board frame: metres, origin at an outer corner of the squares, x along a row, y along a column,
// z = 0 on the board. Corners are numbered from 0, row by row, as OpenCV numbers them.
struct CalibrationBoard {
  BoardPattern pattern = BoardPattern::kCharuco;
  int columns = 9;          // squares
  int rows = 6;             // squares
  double square_m = 0.040;  // side; a marker's side is three quarters of it

  bool IsValid(std::string* error) const;

  int num_corners() const { return (columns - 1) * (rows - 1); }
  // Precondition: 0 <= corner < num_corners().
  Eigen::Vector3d CornerPosition(int corner) const;
};

// "charuco" or "checkerboard"; false for other words.
bool ParseBoardPattern(const std::string& text, BoardPattern* pattern);
const char* ToString(BoardPattern pattern);

// Pixels a square has to have for every edge to fall between pixels: multiples of this.
inline constexpr int kBoardCellsPerSquare = 8;

// The board as it is printed, 8-bit gray, black or white, with a white margin around the squares.
// Precondition: the board is valid; `square_px` is a multiple of kBoardCellsPerSquare.
cv::Mat DrawBoard(const CalibrationBoard& board, int square_px, int margin_px);

// OpenCV's form of a ChArUco board. Precondition: its pattern is one.
cv::Ptr<cv::aruco::CharucoBoard> CharucoBoardOf(const CalibrationBoard& board);

}  // namespace prism
