// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/board/calibration_board.h"

#include <glog/logging.h>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

constexpr double kMarkerPerSquare = 0.75;  // 6 of the 8 cells of a square
constexpr int kMarkers = 250;              // of the dictionary

}  // namespace

bool CalibrationBoard::IsValid(std::string* error) const {
  if (columns < 3 || rows < 3 || columns > 100 || rows > 100) {
    *error = std::to_string(columns) + "x" + std::to_string(rows) +
             " squares, expected 3 to 100 in a row and in a column";
  } else if (!(square_m > 0 && square_m < 10)) {
    *error = "squares of " + std::to_string(1e3 * square_m) + " mm, expected more than 0";
  } else if (pattern == BoardPattern::kCharuco && columns * rows / 2 > kMarkers) {
    *error = std::to_string(columns * rows / 2) + " markers, expected at most " +
             std::to_string(kMarkers);
  } else {
    return true;
  }
  return false;
}

Eigen::Vector3d CalibrationBoard::CornerPosition(int corner) const {
  CHECK_GE(corner, 0);
  CHECK_LT(corner, num_corners());
  const int in_row = columns - 1;
  const int row = corner / in_row;
  return {(corner % in_row + 1) * square_m, (row + 1) * square_m, 0};
}

bool ParseBoardPattern(const std::string& text, BoardPattern* pattern) {
  for (const BoardPattern known : {BoardPattern::kCharuco, BoardPattern::kCheckerboard}) {
    if (text != ToString(known)) continue;
    *pattern = known;
    return true;
  }
  return false;
}

const char* ToString(BoardPattern pattern) {
  return pattern == BoardPattern::kCharuco ? "charuco" : "checkerboard";
}

cv::Mat DrawBoard(const CalibrationBoard& board, int square_px, int margin_px) {
  CHECK_EQ(square_px % kBoardCellsPerSquare, 0);
  const cv::Size size(board.columns * square_px, board.rows * square_px);
  cv::Mat squares(size, CV_8U, cv::Scalar(255));
  if (board.pattern == BoardPattern::kCharuco) {
    CharucoBoardOf(board)->draw(size, squares);
  } else {
    for (int row = 0; row < board.rows; ++row) {
      for (int column = row % 2; column < board.columns; column += 2) {
        squares(cv::Rect(column * square_px, row * square_px, square_px, square_px)).setTo(0);
      }
    }
  }
  cv::Mat image;
  cv::copyMakeBorder(squares,
                     image,
                     margin_px,
                     margin_px,
                     margin_px,
                     margin_px,
                     cv::BORDER_CONSTANT,
                     cv::Scalar(255));
  return image;
}

cv::Ptr<cv::aruco::CharucoBoard> CharucoBoardOf(const CalibrationBoard& board) {
  CHECK(board.pattern == BoardPattern::kCharuco);
  return cv::aruco::CharucoBoard::create(
      board.columns,
      board.rows,
      static_cast<float>(board.square_m),
      static_cast<float>(kMarkerPerSquare * board.square_m),
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_250));
}

}  // namespace prism
