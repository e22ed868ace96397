// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/board_detection.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

constexpr size_t kFewestCorners = 6;
// Images are looked at in twice their size, where markers of few pixels a cell are found.
constexpr double kZoom = 2;

// Whether one homography takes most corners of the markers to where they were seen. With another
// number of squares in a row markers stand elsewhere, and the corners between them are no board's.
bool FitLayout(const cv::aruco::CharucoBoard& board,
               const std::vector<std::vector<cv::Point2f>>& markers,
               const std::vector<int>& ids) {
  constexpr double kLargestError = 0.2;  // of a square; a distorted board's are half of that
  constexpr double kFewest = 0.6;        // of the corners
  std::vector<cv::Point2f> on_board, in_image;
  for (size_t i = 0; i < ids.size(); ++i) {
    const auto known = std::find(board.ids.begin(), board.ids.end(), ids[i]);
    if (known == board.ids.end()) continue;
    const auto& corners = board.objPoints[static_cast<size_t>(known - board.ids.begin())];
    for (size_t k = 0; k < corners.size(); ++k) {
      on_board.emplace_back(corners[k].x, corners[k].y);
      in_image.push_back(markers[i][k]);
    }
  }
  if (on_board.size() < 8) return false;  // one marker fits any board
  const cv::Mat map = cv::findHomography(in_image, on_board, cv::LMEDS);
  if (map.empty()) return false;
  std::vector<cv::Point2f> mapped;
  cv::perspectiveTransform(in_image, mapped, map);
  size_t fit = 0;
  for (size_t i = 0; i < mapped.size(); ++i) {
    fit += cv::norm(mapped[i] - on_board[i]) < kLargestError * board.getSquareLength();
  }
  return static_cast<double>(fit) >= kFewest * static_cast<double>(mapped.size());
}

std::vector<DetectedCorner> DetectCharuco(const CalibrationBoard& board, const cv::Mat& image) {
  const auto charuco = CharucoBoardOf(board);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  parameters->minMarkerPerimeterRate = 0.01;
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, charuco->dictionary, markers, ids, parameters);
  std::vector<cv::Point2f> corners;
  std::vector<int> numbers;
  if (FitLayout(*charuco, markers, ids)) {
    cv::aruco::interpolateCornersCharuco(markers, ids, image, charuco, corners, numbers);
  }
  std::vector<DetectedCorner> detected;
  for (size_t i = 0; i < corners.size(); ++i) {
    detected.push_back({numbers[i], {corners[i].x, corners[i].y}});
  }
  return detected;
}

// Brightness in the middle of the square of row and column -1 or 0 about corner 0.
int SquareAtFirstCorner(const cv::Mat& image,
                        const std::vector<cv::Point2f>& corners,
                        const cv::Size& size,
                        int row,
                        int column) {
  const cv::Point2f along = corners[1] - corners[0];
  const cv::Point2f down = corners[size.width] - corners[0];
  const cv::Point2f at = corners[0] + (row + 0.5f) * down + (column + 0.5f) * along;
  const cv::Point px(cvRound(at.x), cvRound(at.y));
  return cv::Rect({}, image.size()).contains(px) ? image.at<uint8_t>(px) : 255;
}

std::vector<DetectedCorner> DetectCheckerboard(const CalibrationBoard& board,
                                               const cv::Mat& image) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.columns - 1, board.rows - 1);
  if (!cv::findChessboardCornersSB(
          image, size, corners, cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY)) {
    return {};
  }
  // The board's first square is black: otherwise it was found upside down.
  if (SquareAtFirstCorner(image, corners, size, -1, -1) >
      SquareAtFirstCorner(image, corners, size, -1, 0)) {
    std::reverse(corners.begin(), corners.end());
  }
  std::vector<DetectedCorner> detected;
  for (size_t i = 0; i < corners.size(); ++i) {
    detected.push_back({static_cast<int>(i), {corners[i].x, corners[i].y}});
  }
  return detected;
}

// Where the edges of the squares cross: the point nearest to all lines across the gradients along
// them. cv::cornerSubPix does so with all gradients of a window, in which a ChArUco board has its
// markers, an eighth of a square away; here those near the edges count.
class CornerRefinement {
 public:
  CornerRefinement(const CalibrationBoard& board, const cv::Mat& image) : board_(board) {
    cv::Mat blurred;
    image.convertTo(blurred, CV_32F);
    cv::Scharr(blurred, gradient_x_, CV_32F, 1, 0);
    cv::Scharr(blurred, gradient_y_, CV_32F, 0, 1);
  }

  // Corners that have no such point nearby, or do not fit the others, are removed.
  void Refine(std::vector<DetectedCorner>* corners) const {
    const cv::Mat map = BoardToImage(*corners);
    if (map.empty()) {
      corners->clear();
      return;
    }
    const cv::Matx33d H(map);
    std::vector<DetectedCorner> refined;
    for (DetectedCorner corner : *corners) {
      const Eigen::Vector2d expected = Map(H, BoardPosition(corner.corner));
      const Eigen::Vector2d along = Map(H, BoardPosition(corner.corner) + Eigen::Vector2d(0.5, 0)) -
                                    Map(H, BoardPosition(corner.corner) - Eigen::Vector2d(0.5, 0));
      const Eigen::Vector2d down = Map(H, BoardPosition(corner.corner) + Eigen::Vector2d(0, 0.5)) -
                                   Map(H, BoardPosition(corner.corner) - Eigen::Vector2d(0, 0.5));
      corner.spacing_px = std::min(along.norm(), down.norm());
      // A distorted board fits its neighbours to a part of a square.
      if ((corner.px - expected).norm() > 0.25 * corner.spacing_px) continue;
      if (RefineOne(along, down, &corner.px)) refined.push_back(corner);
    }
    *corners = refined;
  }

 private:
  Eigen::Vector2d BoardPosition(int corner) const {  // in squares
    return board_.CornerPosition(corner).head<2>() / board_.square_m;
  }

  static Eigen::Vector2d Map(const cv::Matx33d& H, const Eigen::Vector2d& p) {
    const cv::Vec3d q = H * cv::Vec3d(p.x(), p.y(), 1);
    return {q[0] / q[2], q[1] / q[2]};
  }

  cv::Mat BoardToImage(const std::vector<DetectedCorner>& corners) const {
    std::vector<cv::Point2d> on_board, in_image;
    for (const DetectedCorner& corner : corners) {
      const Eigen::Vector2d p = BoardPosition(corner.corner);
      on_board.emplace_back(p.x(), p.y());
      in_image.emplace_back(corner.px.x(), corner.px.y());
    }
    return cv::findHomography(on_board, in_image, cv::LMEDS);
  }

  bool RefineOne(const Eigen::Vector2d& along,
                 const Eigen::Vector2d& down,
                 Eigen::Vector2d* px) const {
    constexpr double kEdgeLength = 0.45;  // of a square, to either side
    constexpr double kEdgeWidth = 0.06;   // of a square, to either side
    constexpr double kNarrowest = 1.5;    // px: an edge is as wide as the image is sharp
    constexpr int kIterations = 8;
    Eigen::Matrix2d edges;
    edges << along, down;
    const Eigen::Matrix2d to_squares = edges.inverse();
    const double width_down = std::max(kEdgeWidth, kNarrowest / down.norm());
    const double width_along = std::max(kEdgeWidth, kNarrowest / along.norm());
    const int reach = static_cast<int>(std::ceil(kEdgeLength * (along.norm() + down.norm())));
    const Eigen::Vector2d start = *px;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Eigen::Matrix2d G = Eigen::Matrix2d::Zero();
      Eigen::Vector2d right = Eigen::Vector2d::Zero();
      const int cx = static_cast<int>(std::lround(px->x()));
      const int cy = static_cast<int>(std::lround(px->y()));
      for (int y = cy - reach; y <= cy + reach; ++y) {
        for (int x = cx - reach; x <= cx + reach; ++x) {
          if (x < 0 || y < 0 || x >= gradient_x_.cols || y >= gradient_x_.rows) continue;
          const Eigen::Vector2d offset(x - px->x(), y - px->y());
          const Eigen::Vector2d squares = (to_squares * offset).cwiseAbs();
          if (squares.maxCoeff() > kEdgeLength) continue;
          if (squares.y() > width_down && squares.x() > width_along) continue;
          const Eigen::Vector2d g(gradient_x_.at<float>(y, x), gradient_y_.at<float>(y, x));
          G += g * g.transpose();
          right += g * g.dot(offset);
        }
      }
      if (!(G.determinant() > 1e-3 * G.trace() * G.trace())) return false;
      const Eigen::Vector2d step = G.inverse() * right;
      *px += step;
      if ((*px - start).norm() > 0.25 * std::min(along.norm(), down.norm())) return false;
      if (step.norm() < 1e-3) break;
    }
    return true;
  }

  const CalibrationBoard& board_;
  cv::Mat gradient_x_, gradient_y_;
};

}  // namespace

std::vector<DetectedCorner> DetectBoard(const CalibrationBoard& board, const ImageF& image) {
  const cv::Mat pixels(image.height(), image.width(), CV_32F, const_cast<float*>(image.data()));
  cv::Mat bytes, large;
  pixels.convertTo(bytes, CV_8U);
  cv::resize(bytes, large, {}, kZoom, kZoom, cv::INTER_CUBIC);
  std::vector<DetectedCorner> corners = board.pattern == BoardPattern::kCharuco
                                            ? DetectCharuco(board, large)
                                            : DetectCheckerboard(board, large);
  if (corners.size() < kFewestCorners) return {};
  // Pixel centres are integers on either grid.
  for (DetectedCorner& corner : corners) corner.px = (corner.px.array() + 0.5) / kZoom - 0.5;
  CornerRefinement(board, bytes).Refine(&corners);
  if (corners.size() < kFewestCorners) return {};
  return corners;
}

}  // namespace prism
