// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/board/calibration_board.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace prism {
namespace {

// Brightness just inside the four squares that meet at a corner.
std::vector<int> SquaresAround(const cv::Mat& image, const Eigen::Vector2d& px) {
  std::vector<int> values;
  for (const int dy : {-2, 1}) {
    for (const int dx : {-2, 1}) {
      values.push_back(image.at<uint8_t>(static_cast<int>(std::lround(px.y())) + dy,
                                         static_cast<int>(std::lround(px.x())) + dx));
    }
  }
  return values;
}

TEST(CalibrationBoard, CornersAreWhereBlackMeetsWhite) {
  for (const BoardPattern pattern : {BoardPattern::kCharuco, BoardPattern::kCheckerboard}) {
    for (const int columns : {4, 5}) {
      CalibrationBoard board;
      board.pattern = pattern;
      board.columns = columns;
      board.rows = 6;
      board.square_m = 0.03;
      const int square_px = 32, margin_px = 10;
      const cv::Mat image = DrawBoard(board, square_px, margin_px);
      ASSERT_EQ(image.cols, columns * square_px + 2 * margin_px);
      for (int i = 0; i < board.num_corners(); ++i) {
        const Eigen::Vector2d px = board.CornerPosition(i).head<2>() / board.square_m * square_px +
                                   Eigen::Vector2d(margin_px, margin_px);
        const std::vector<int> around = SquaresAround(image, px);
        EXPECT_EQ(around[0], around[3]) << ToString(pattern) << " corner " << i;
        EXPECT_EQ(around[1], around[2]) << ToString(pattern) << " corner " << i;
        EXPECT_NE(around[0], around[1]) << ToString(pattern) << " corner " << i;
      }
    }
  }
}

TEST(CalibrationBoard, BoardsThatCannotBeAreExplained) {
  CalibrationBoard board;
  std::string error;
  EXPECT_TRUE(board.IsValid(&error));
  board.square_m = 0;
  EXPECT_FALSE(board.IsValid(&error));
  EXPECT_NE(error.find("mm"), std::string::npos);
  board = CalibrationBoard();
  board.columns = 2;
  EXPECT_FALSE(board.IsValid(&error));
  board = CalibrationBoard();
  board.columns = board.rows = 40;  // more markers than there are
  EXPECT_FALSE(board.IsValid(&error));
  board.pattern = BoardPattern::kCheckerboard;
  EXPECT_TRUE(board.IsValid(&error));
}

}  // namespace
}  // namespace prism
