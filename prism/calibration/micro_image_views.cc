// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/micro_image_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include <Eigen/Cholesky>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

constexpr size_t kFewestImages = 4;
constexpr size_t kFewestCorners = 6;
constexpr double kTypicalPx = 0.5;       // of a corner in a micro image, raw px; scaled later
constexpr double kLatticeMisfit = 0.15;  // of the distance of corners, RMS
constexpr double kHuber = 1.5;

// p and m of one corner.
std::optional<CornerObservation> FitLine(const std::vector<const MicroImageCorner*>& images) {
  if (images.size() < kFewestImages) return std::nullopt;
  std::vector<double> weights(images.size(), 1);
  CornerObservation fit;
  double spread = 0;
  for (int iteration = 0; iteration < 10; ++iteration) {
    double sum = 0;
    Eigen::Vector2d center = Eigen::Vector2d::Zero(), px = Eigen::Vector2d::Zero();
    for (size_t i = 0; i < images.size(); ++i) {
      sum += weights[i];
      center += weights[i] * images[i]->micro_image_px;
      px += weights[i] * images[i]->px;
    }
    fit.micro_image_px = center / sum;
    fit.px = px / sum;
    double product = 0;
    spread = 0;
    for (size_t i = 0; i < images.size(); ++i) {
      const Eigen::Vector2d d = images[i]->micro_image_px - fit.micro_image_px;
      product += weights[i] * d.dot(images[i]->px - fit.px);
      spread += weights[i] * d.squaredNorm();
    }
    if (!(spread > 0)) return std::nullopt;
    fit.slope = product / spread;
    for (size_t i = 0; i < images.size(); ++i) {
      const Eigen::Vector2d misfit =
          fit.px + fit.slope * (images[i]->micro_image_px - fit.micro_image_px) - images[i]->px;
      weights[i] = std::min(1.0, kHuber * kTypicalPx / std::max(misfit.norm(), 1e-9));
    }
  }
  double sum = 0;
  for (const double weight : weights) sum += weight;
  fit.px_sigma = kTypicalPx / std::sqrt(sum);
  fit.slope_sigma = kTypicalPx / std::sqrt(spread);
  return fit;
}

cv::Point2d ChiefPixel(const CornerObservation& corner) {
  const Eigen::Vector2d px = corner.ChiefPx();
  return {px.x(), px.y()};
}

// How far the corners are from a perspective picture of the board with these numbers, in squares.
double Misfit(const CalibrationBoard& board, const std::vector<CornerObservation>& corners) {
  std::vector<cv::Point2d> on_board, in_image;
  std::set<int> numbers;
  for (const CornerObservation& corner : corners) {
    if (corner.corner < 0 || corner.corner >= board.num_corners() ||
        !numbers.insert(corner.corner).second) {
      return std::numeric_limits<double>::infinity();
    }
    const Eigen::Vector3d p = board.CornerPosition(corner.corner) / board.square_m;
    on_board.emplace_back(p.x(), p.y());
    in_image.push_back(ChiefPixel(corner));
  }
  const cv::Mat map = cv::findHomography(in_image, on_board);
  if (map.empty()) return std::numeric_limits<double>::infinity();
  std::vector<cv::Point2d> mapped;
  cv::perspectiveTransform(in_image, mapped, map);
  double squares = 0;
  for (size_t i = 0; i < mapped.size(); ++i) {
    const cv::Point2d d = mapped[i] - on_board[i];
    squares += d.dot(d);
  }
  return std::sqrt(squares / mapped.size());
}

// Corners numbered as the picture's own numbers say.
std::vector<CornerObservation> Renumber(const CalibrationBoard& board,
                                        std::vector<CornerObservation> corners,
                                        bool by_columns,
                                        int first) {
  const int in_row = board.columns - 1, in_column = board.rows - 1;
  for (CornerObservation& corner : corners) {
    const int n = corner.corner - first;
    if (by_columns && n >= 0) corner.corner = n % in_column * in_row + n / in_column;
    if (!by_columns) corner.corner = n;
  }
  return corners;
}

// Numbers from the lattice itself: the outermost corners in four directions, turned in steps, are
// taken for those of the board, and the others fall into place or not.
std::vector<CornerObservation> NumberByLattice(const CalibrationBoard& board,
                                               const std::vector<CornerObservation>& corners) {
  const int columns = board.columns - 1, rows = board.rows - 1;
  std::vector<cv::Point2d> px;
  for (const CornerObservation& corner : corners) px.push_back(ChiefPixel(corner));
  double best = std::numeric_limits<double>::infinity();
  std::vector<CornerObservation> numbered;
  for (int turn = 0; turn < 16; ++turn) {
    // Clockwise in the image, as the board's corners are on the board.
    std::vector<cv::Point2f> outer;
    for (int side = 0; side < 4; ++side) {
      const double angle = M_PI * (turn / 8.0 + side / 2.0 - 0.75);
      const cv::Point2d direction(std::cos(angle), std::sin(angle));
      outer.emplace_back(*std::max_element(px.begin(), px.end(), [&](const auto& a, const auto& b) {
        return a.dot(direction) < b.dot(direction);
      }));
    }
    const std::vector<cv::Point2f> board_outer = {
        {0, 0}, {columns - 1.0f, 0}, {columns - 1.0f, rows - 1.0f}, {0, rows - 1.0f}};
    if (cv::contourArea(outer) < 1) continue;
    std::vector<cv::Point2d> mapped;
    cv::perspectiveTransform(px, mapped, cv::getPerspectiveTransform(outer, board_outer));
    std::vector<CornerObservation> trial = corners;
    for (size_t i = 0; i < trial.size(); ++i) {
      const int x = cvRound(mapped[i].x), y = cvRound(mapped[i].y);
      const bool inside = x >= 0 && y >= 0 && x < columns && y < rows;
      trial[i].corner = inside ? y * columns + x : -1;
    }
    const double misfit = Misfit(board, trial);
    if (misfit < best) {
      best = misfit;
      numbered = trial;
    }
  }
  return best < kLatticeMisfit ? numbered : std::vector<CornerObservation>();
}

}  // namespace

std::vector<BoardView> ViewsFromMicroImages(const CalibrationBoard& board,
                                            const std::vector<MicroImageCorner>& corners) {
  std::map<int, std::map<int, std::vector<const MicroImageCorner*>>> frames;
  for (const MicroImageCorner& corner : corners) {
    frames[corner.frame][corner.cluster].push_back(&corner);
  }
  std::vector<BoardView> views;
  for (const auto& [frame, clusters] : frames) {
    std::vector<CornerObservation> seen;
    for (const auto& [cluster, images] : clusters) {
      std::optional<CornerObservation> corner = FitLine(images);
      if (!corner) continue;
      corner->corner = cluster;
      seen.push_back(*corner);
    }
    BoardView view;
    view.name = "frame " + std::to_string(frame);
    if (seen.size() >= kFewestCorners) {
      double best = kLatticeMisfit;
      for (const bool by_columns : {false, true}) {
        for (const int first : {0, 1}) {
          const auto trial = Renumber(board, seen, by_columns, first);
          const double misfit = Misfit(board, trial);
          if (misfit >= best) continue;
          best = misfit;
          view.corners = trial;
        }
      }
      if (view.corners.empty()) view.corners = NumberByLattice(board, seen);
    }
    views.push_back(std::move(view));
  }
  return views;
}

bool IsKeplerian(const std::vector<BoardView>& views) {
  long above = 0, all = 0;
  for (const BoardView& view : views) {
    for (const CornerObservation& corner : view.corners) {
      above += corner.slope > 1;
      ++all;
    }
  }
  return 2 * above > all;
}

}  // namespace prism
