// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/calibration_start.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>

namespace prism {
namespace {

constexpr size_t kFewestCorners = 6;
// Slopes of the line can be told from its intercept where 1 / (z - f_L) spreads by this share.
constexpr double kSmallestSpread = 0.05;

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
    const double image_distance = current.main_lens_mla_distance + current.sensor_mla_distance;
    const double focal_px = image_distance / current.raw_pixel_size;
    const cv::Matx33d intrinsics(focal_px,
                                 0,
                                 current.raw_principal_point.x(),
                                 0,
                                 focal_px,
                                 current.raw_principal_point.y(),
                                 0,
                                 0,
                                 1);
    const double kappa = MicroLensCenterScale(current);
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
      for (const CornerObservation& corner : view.corners) {
        const double z = (*pose * board.CornerPosition(corner.corner)).z();
        const double w = sign * (1 - corner.slope / kappa);
        if (!(z > 1.01 * f) || !(w > 0)) continue;
        const double v_sigma = corner.slope_sigma / (w * w);
        line.push_back({1 / (z - f), 1 / w, 1 / (v_sigma * v_sigma)});
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
