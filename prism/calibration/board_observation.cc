// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/board_observation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "prism/base/statistics.h"
#include "prism/calibration/camera_model.h"
#include "prism/camera/projection.h"

namespace prism {
namespace {

constexpr double kCornerSigma = 0.1;   // of a detected corner, focused px; scaled by the adjustment
constexpr double kFitRadius = 0.5;     // of the spacing of corners
constexpr double kLargestRadius = 25;  // focused px
constexpr double kSmallestRadius = 6;
constexpr size_t kFewestDepths = 12;
constexpr double kHuber = 1.5;  // standard deviations

struct Sample {
  Eigen::Vector3d basis;  // 1, offset from the corner
  double w, weight;
};

std::vector<Sample> SamplesAround(const LightFieldFrame& frame,
                                  const Eigen::Vector2d& px,
                                  double radius) {
  const ImageF& depth = frame.inverse_virtual_depth;
  std::vector<Sample> samples;
  const int x0 = std::max(0, static_cast<int>(std::ceil(px.x() - radius)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(px.y() - radius)));
  const int x1 = std::min(depth.width() - 1, static_cast<int>(px.x() + radius));
  const int y1 = std::min(depth.height() - 1, static_cast<int>(px.y() + radius));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - px;
      if (depth(x, y) == 0 || offset.norm() > radius) continue;
      const double sigma = frame.sigma(x, y);
      samples.push_back({{1, offset.x(), offset.y()}, depth(x, y), 1 / (sigma * sigma)});
    }
  }
  return samples;
}

}  // namespace

std::optional<LocalDepth> FitLocalDepth(const LightFieldFrame& frame,
                                        const Eigen::Vector2d& px,
                                        double radius) {
  const std::vector<Sample> samples = SamplesAround(frame, px, radius);
  if (samples.size() < kFewestDepths) return std::nullopt;
  // Start at the median, so that a group of gross errors does not decide.
  std::vector<double> depths;
  for (const Sample& sample : samples) depths.push_back(sample.w);
  Eigen::Vector3d plane(UpperMedian(depths), 0, 0);
  Eigen::Matrix3d information;
  double weights = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    std::vector<double> misfits;
    for (const Sample& sample : samples) {
      misfits.push_back(std::abs(sample.w - plane.dot(sample.basis)) * std::sqrt(sample.weight));
    }
    const double scale = std::max(UpperMedian(misfits) / 0.6745, 1e-6);
    information.setZero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    weights = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      const Sample& sample = samples[i];
      const double robust = std::min(1.0, kHuber * scale / std::max(misfits[i], 1e-12));
      const double weight = robust * sample.weight;
      information += weight * sample.basis * sample.basis.transpose();
      right += weight * sample.w * sample.basis;
      weights += weight;
    }
    plane = information.ldlt().solve(right);
  }
  // Depths on all sides: the value at the corner is not an extrapolation.
  const Eigen::Vector2d middle = information.block<2, 1>(1, 0) / weights;
  if (middle.norm() > 0.5 * radius) return std::nullopt;
  // Samples within the correlation of the errors count as one.
  const double area = M_PI * radius * radius;
  const double correlated = 2 * M_PI * frame.depth_correlation_px * frame.depth_correlation_px;
  const double density = static_cast<double>(samples.size()) / area;
  const double repeated = 1 + std::min(correlated, area) * density;
  const double variance = information.inverse()(0, 0) * repeated;
  return LocalDepth{plane[0], std::sqrt(variance)};
}

BoardView ObserveBoard(const CalibrationBoard& board,
                       const PlenopticCamera& camera,
                       const LightFieldFrame& frame,
                       const ImageF& dense) {
  return ObserveCorners(DetectBoard(board, frame.image[0]), camera, frame, dense);
}

BoardView ObserveCorners(const std::vector<DetectedCorner>& corners,
                         const PlenopticCamera& camera,
                         const LightFieldFrame& frame,
                         const ImageF& dense) {
  const double kappa = MicroLensCenterScale(camera);
  const double sign = camera.virtual_depth_sign();
  const Eigen::Vector2d c = camera.raw_principal_point;
  BoardView view;
  for (const DetectedCorner& detected : corners) {
    const double radius =
        std::clamp(kFitRadius * detected.spacing_px, kSmallestRadius, kLargestRadius);
    const std::optional<LocalDepth> depth = FitLocalDepth(frame, detected.px, radius);
    if (!depth) continue;
    double focused_at = depth->inverse_virtual_depth;
    if (!dense.empty()) {
      const float d = dense(static_cast<int>(std::lround(detected.px.x())),
                            static_cast<int>(std::lround(detected.px.y())));
      if (d > 0) focused_at = d;
    }
    const double q = sign * focused_at;
    // From a pixel's place to x_0, about the principal point. Of chief rays: (b_L0 + B) / f_L,
    // whatever the depth, if Eq. (8) applies.
    double chief_scale = q / (1 - (1 - q) * kappa);
    if (camera.focused_image == FocusedImage::kChiefRays) {
      chief_scale *= (camera.main_lens_mla_distance + camera.sensor_mla_distance / q) /
                     camera.focal_length;  // b_L / f_L
    }
    const Eigen::Vector2d chief =
        DistortRaw(camera, c + (RawFromFocused(camera, detected.px) - c) * chief_scale);
    CornerObservation corner;
    corner.corner = detected.corner;
    corner.micro_image_px = chief;
    corner.px = chief;
    corner.slope = (1 - sign * depth->inverse_virtual_depth) * kappa;
    corner.px_sigma =
        kCornerSigma * camera.focused_scale * std::abs(chief_scale * (1 - corner.slope));
    corner.slope_sigma = kappa * depth->sigma;
    view.corners.push_back(corner);
  }
  return view;
}

}  // namespace prism
