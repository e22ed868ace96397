// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/calibration_start.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>

#include "prism/base/statistics.h"

namespace prism {
namespace {

constexpr size_t kFewestCorners = 6;
// Slopes of the line can be told from its intercept where 1 / (z - f_L) spreads by this share.
constexpr double kSmallestSpread = 0.05;
// Of v, and of the median over the views: less is what depths, and distances by a camera that is
// only guessed, leave between views of one camera. 10 um of b_L0 are 1 % with a 16 mm lens.
constexpr double kStrange = 0.01;
constexpr double kStrangeOfMedian = 8;
constexpr size_t kFewestViews = 4;  // that can outvote one

struct Correspondences {
  std::vector<cv::Point3f> board;
  std::vector<cv::Point2f> image;
};

Correspondences CorrespondencesOf(const CalibrationBoard& board, const BoardView& view) {
  Correspondences points;
  for (const CornerObservation& corner : view.corners) {
    const Eigen::Vector3f p = board.CornerPosition(corner.corner).cast<float>();
    points.board.emplace_back(p.x(), p.y(), p.z());
    const Eigen::Vector2f px = corner.ChiefPx().cast<float>();
    points.image.emplace_back(px.x(), px.y());
  }
  return points;
}

bool AreInARow(const std::vector<cv::Point3f>& points) {
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += Eigen::Vector2d(p.x, p.y) / points.size();
  for (const auto& p : points) {
    const Eigen::Vector2d d = Eigen::Vector2d(p.x, p.y) - mean;
    spread += d * d.transpose();
  }
  return spread.determinant() < 1e-3 * std::pow(spread.trace(), 2);
}

std::optional<SE3> PoseOf(const CalibrationBoard& board,
                          const BoardView& view,
                          const cv::Matx33d& intrinsics) {
  const Correspondences points = CorrespondencesOf(board, view);
  if (points.board.size() < kFewestCorners || AreInARow(points.board)) return std::nullopt;
  cv::Mat rvec, tvec;
  if (!cv::solvePnP(points.board,
                    points.image,
                    intrinsics,
                    cv::noArray(),
                    rvec,
                    tvec,
                    false,
                    cv::SOLVEPNP_IPPE)) {
    return std::nullopt;
  }
  cv::solvePnPRefineLM(points.board, points.image, intrinsics, cv::noArray(), rvec, tvec);
  const Eigen::Vector3d rotation(rvec.at<double>(0), rvec.at<double>(1), rvec.at<double>(2));
  const Eigen::Vector3d translation(tvec.at<double>(0), tvec.at<double>(1), tvec.at<double>(2));
  const double angle = rotation.norm();
  const Eigen::Vector3d axis =
      angle > 0 ? Eigen::Vector3d(rotation / angle) : Eigen::Vector3d::UnitX();
  if (!(translation.z() > 0)) return std::nullopt;
  return SE3(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), translation);
}

struct LinePoint {
  double x, v, weight;  // 1 / (z - f_L), virtual depth
};

// v = v_inf + k x, Huber. False if x does not spread.
bool FitLine(const std::vector<LinePoint>& points, double* v_inf, double* k) {
  double low = points[0].x, high = low;
  for (const LinePoint& p : points) {
    low = std::min(low, p.x);
    high = std::max(high, p.x);
  }
  if (high - low < kSmallestSpread * high) return false;
  std::vector<double> misfits(points.size(), 0);
  double scale = 1;
  for (int iteration = 0; iteration < 20; ++iteration) {
    double s = 0, sx = 0, sxx = 0, sv = 0, sxv = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const LinePoint& p = points[i];
      const double robust = iteration == 0 ? 1 : std::min(1.0, 1.5 * scale / (misfits[i] + 1e-12));
      const double w = robust * p.weight;
      s += w;
      sx += w * p.x;
      sxx += w * p.x * p.x;
      sv += w * p.v;
      sxv += w * p.x * p.v;
    }
    *k = (s * sxv - sx * sv) / (s * sxx - sx * sx);
    *v_inf = (sv - *k * sx) / s;
    for (size_t i = 0; i < points.size(); ++i) {
      misfits[i] = std::abs(points[i].v - *v_inf - *k * points[i].x) * std::sqrt(points[i].weight);
    }
    std::vector<double> sorted = misfits;
    const auto middle = sorted.begin() + static_cast<long>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    scale = *middle / 0.6745;
  }
  return true;
}

cv::Matx33d IntrinsicsOf(const PlenopticCamera& camera) {
  const double image_distance = camera.main_lens_mla_distance + camera.sensor_mla_distance;
  const double focal_px = image_distance / camera.raw_pixel_size;
  const Eigen::Vector2d& c = camera.raw_principal_point;
  return {focal_px, 0, c.x(), 0, focal_px, c.y(), 0, 0, 1};
}

// Corners of a view that have a distance and a virtual depth.
std::vector<LinePoint> LinePointsOf(const CalibrationBoard& board,
                                    const PlenopticCamera& camera,
                                    const BoardView& view,
                                    const SE3& pose) {
  const double kappa = MicroLensCenterScale(camera);
  std::vector<LinePoint> points;
  for (const CornerObservation& corner : view.corners) {
    const double z = (pose * board.CornerPosition(corner.corner)).z();
    const double w = camera.virtual_depth_sign() * (1 - corner.slope / kappa);
    if (!(z > 1.01 * camera.focal_length) || !(w > 0)) continue;
    const double v_sigma = corner.slope_sigma / (w * w);
    points.push_back({1 / (z - camera.focal_length), 1 / w, 1 / (v_sigma * v_sigma)});
  }
  return points;
}

// Of (v - v_inf - k x) / v.
double MedianMisfit(const std::vector<LinePoint>& points, double v_inf, double k) {
  std::vector<double> misfits;
  for (const LinePoint& p : points) misfits.push_back((p.v - v_inf - k * p.x) / p.v);
  return std::abs(UpperMedian(misfits));
}

}  // namespace

std::optional<double> FocalLengthFromBoards(const CalibrationBoard& board,
                                            const std::vector<BoardView>& views,
                                            const PlenopticCamera& camera) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardView& view : views) {
    const Correspondences of_view = CorrespondencesOf(board, view);
    if (of_view.board.size() < kFewestCorners || AreInARow(of_view.board)) continue;
    points.push_back(of_view.board);
    pixels.push_back(of_view.image);
  }
  if (points.empty()) return std::nullopt;
  const cv::Mat intrinsics =
      cv::initCameraMatrix2D(points, pixels, {camera.raw_width, camera.raw_height}, 1);
  const double focal_length = intrinsics.at<double>(0, 0);
  if (!(focal_length > 0) || !std::isfinite(focal_length)) return std::nullopt;
  return focal_length;
}

std::vector<int> FindStrangers(const CalibrationBoard& board,
                               const PlenopticCamera& camera,
                               const std::vector<BoardView>& views) {
  struct ViewOnLine {
    int index;
    std::vector<LinePoint> points;
    double x, v;  // medians
  };
  std::vector<ViewOnLine> all;
  double farthest = 0;
  for (size_t k = 0; k < views.size(); ++k) {
    const std::optional<SE3> pose = PoseOf(board, views[k], IntrinsicsOf(camera));
    if (!pose) continue;
    ViewOnLine view{static_cast<int>(k), LinePointsOf(board, camera, views[k], *pose), 0, 0};
    if (view.points.empty()) continue;
    std::vector<double> x, v;
    for (const LinePoint& point : view.points) {
      x.push_back(point.x);
      v.push_back(point.v);
    }
    view.x = UpperMedian(x);
    view.v = UpperMedian(v);
    farthest = std::max(farthest, view.x);
    all.push_back(std::move(view));
  }
  if (all.size() < kFewestViews) return {};
  std::vector<double> misfits;  // of the best line
  double least = INFINITY;
  for (size_t i = 0; i < all.size(); ++i) {
    for (size_t j = i + 1; j < all.size(); ++j) {
      const double spread = all[j].x - all[i].x;
      if (std::abs(spread) < kSmallestSpread * farthest) continue;
      const double k = (all[j].v - all[i].v) / spread;
      if (!(camera.virtual_depth_sign() * k > 0)) continue;
      const double v_inf = all[i].v - k * all[i].x;
      std::vector<double> of_line;
      for (const ViewOnLine& view : all) of_line.push_back(MedianMisfit(view.points, v_inf, k));
      const double median = UpperMedian(of_line);
      if (!(median < least)) continue;
      least = median;
      misfits = of_line;
    }
  }
  std::vector<int> strangers;
  for (size_t i = 0; i < misfits.size(); ++i) {
    if (misfits[i] > std::max(kStrange, kStrangeOfMedian * least))
      strangers.push_back(all[i].index);
  }
  return strangers;
}

std::optional<CalibrationState> StartCalibration(const CalibrationBoard& board,
                                                 const PlenopticCamera& camera,
                                                 bool hold_sensor_distance,
                                                 std::vector<BoardView>* views) {
  const double sign = camera.virtual_depth_sign();
  CalibrationState state;
  state.camera = ParametersOf(camera);
  state.cam_from_board.resize(views->size());
  state.depth_offsets.assign(views->size(), 0);
  PlenopticCamera current = camera;
  bool any = false;
  for (int round = 0; round < 4; ++round) {  // poses know b_L0 + B, then v_inf and B
    const cv::Matx33d intrinsics = IntrinsicsOf(current);
    const double f = current.focal_length;
    std::vector<LinePoint> line;
    any = false;
    for (size_t k = 0; k < views->size(); ++k) {
      BoardView& view = (*views)[k];
      const std::optional<SE3> pose = PoseOf(board, view, intrinsics);
      if (!pose) {
        view.corners.clear();
        continue;
      }
      state.cam_from_board[k] = *pose;
      any = true;
      for (const LinePoint& point : LinePointsOf(board, current, view, *pose)) {
        line.push_back(point);
      }
    }
    if (line.size() < 2 * kFewestCorners) return std::nullopt;
    double v_inf = 0, k = 0;
    if (FitLine(line, &v_inf, &k) && sign * k > 0) {
      if (!hold_sensor_distance) state.camera[kSensorDistance] = f * f / std::abs(k);
      state.camera[kInfinityDepth] = v_inf;
    }
    current = WithParameters(current, state.camera);
    if (!(current.main_lens_mla_distance > 0)) return std::nullopt;
  }
  if (!any) return std::nullopt;
  return state;
}

}  // namespace prism
