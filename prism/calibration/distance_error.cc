// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/distance_error.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>

#include "prism/base/statistics.h"
#include "prism/camera/projection.h"

namespace prism {
namespace {

using CameraCovariance = Eigen::Matrix<double, kNumCameraParameters, kNumCameraParameters>;

// z of q = sign / v under a set of parameters.
double DistanceOf(const FixedFigures& fixed, const CameraParameters& p, double q) {
  const double b_L0 = p[kFocalLength] - fixed.sign * p[kInfinityDepth] * p[kSensorDistance];
  const double b_L = b_L0 + p[kSensorDistance] / q;
  return 1 / (1 / p[kFocalLength] - 1 / b_L);
}

double InverseDepthOf(const FixedFigures& fixed, const CameraParameters& p, double z) {
  RawAppearance<double> appearance;
  const Eigen::Vector3d x_C(0, 0, z);
  return Appear(fixed, p.data(), x_C, &appearance) ? appearance.inverse_depth : NAN;
}

// Standard deviation of z / z at a measured q, from the covariance of the parameters.
double DistanceSigma(const FixedFigures& fixed,
                     const CameraParameters& p,
                     const CameraCovariance& covariance,
                     double z) {
  const double q = InverseDepthOf(fixed, p, z);
  Eigen::Matrix<double, kNumCameraParameters, 1> gradient;
  gradient.setZero();
  for (const CameraParameter i : {kFocalLength, kInfinityDepth, kSensorDistance}) {
    const double step = 1e-6 * p[i];
    CameraParameters above = p, below = p;
    above[i] += step;
    below[i] -= step;
    gradient[i] = (DistanceOf(fixed, above, q) - DistanceOf(fixed, below, q)) / (2 * step * z);
  }
  return std::sqrt(gradient.dot(covariance * gradient));
}

}  // namespace

double RelativeDistanceSigma(const CalibrationResult& result, double distance_m) {
  CHECK(result.adjustment.covariance);
  return DistanceSigma(
      FixedFigures(result.camera), result.state.camera, *result.adjustment.covariance, distance_m);
}

CameraFigures FiguresOf(const CalibrationResult& result) {
  CHECK(result.adjustment.covariance);
  const CameraParameters& p = result.state.camera;
  const double sign = result.camera.virtual_depth_sign();
  // b_L0 in place of v_inf.
  CameraCovariance J = CameraCovariance::Identity();
  J(kInfinityDepth, kFocalLength) = 1;
  J(kInfinityDepth, kInfinityDepth) = -sign * p[kSensorDistance];
  J(kInfinityDepth, kSensorDistance) = -sign * p[kInfinityDepth];
  const CameraCovariance covariance = J * *result.adjustment.covariance * J.transpose();
  CameraFigures figures;
  const std::pair<const char*, const char*> names[kNumCameraParameters] = {{"f_L", "m"},
                                                                           {"b_L0", "m"},
                                                                           {"B", "m"},
                                                                           {"c_x", "px"},
                                                                           {"c_y", "px"},
                                                                           {"A0", "1/m^2"},
                                                                           {"A1", "1/m^4"},
                                                                           {"B0", "1/m"},
                                                                           {"B1", "1/m"}};
  figures.correlations = Eigen::MatrixXd::Zero(kNumCameraParameters, kNumCameraParameters);
  for (int i = 0; i < kNumCameraParameters; ++i) {
    const double value = i == kInfinityDepth ? result.camera.main_lens_mla_distance : p[i];
    const double sigma = std::sqrt(std::max(0.0, covariance(i, i)));
    figures.figures.push_back({names[i].first, names[i].second, value, sigma, result.held[i]});
    for (int j = 0; j < kNumCameraParameters; ++j) {
      const double scale = std::sqrt(covariance(i, i) * covariance(j, j));
      if (scale > 0) figures.correlations(i, j) = covariance(i, j) / scale;
    }
  }
  return figures;
}

std::vector<LeftOutView> LeaveOneOut(const CalibrationBoard& board,
                                     const CalibrationResult& result) {
  const FixedFigures fixed(result.camera);
  AdjustmentOptions options;
  options.estimate_noise = false;
  std::vector<LeftOutView> left_out;
  for (size_t k = 0; k < result.views.size(); ++k) {
    if (result.views[k].corners.empty()) continue;
    CalibrationState state = result.state;
    CalibrationNoise noise = result.noise;
    std::vector<BoardView> others = result.views;
    others[k].corners.clear();
    options.held = result.held;
    const AdjustmentResult without =
        AdjustCalibration(board, others, fixed, options, &noise, &state);
    if (!without.covariance) continue;  // it takes this view to determine the camera

    // The view's pose by positions alone: slopes count for nothing.
    std::vector<BoardView> alone(result.views.size());
    alone[k] = result.views[k];
    for (CornerObservation& corner : alone[k].corners) corner.slope_sigma = 1e3;
    options.held.fill(true);
    AdjustCalibration(board, alone, fixed, options, &noise, &state);

    LeftOutView view;
    view.name = result.views[k].name;
    const SE3& pose = state.cam_from_board[k];
    view.distance_m = (pose * MiddleOfCorners(board, result.views[k])).z();
    std::vector<double> errors, variances;
    for (const CornerObservation& corner : result.views[k].corners) {
      const Eigen::Vector3d x_C = pose * board.CornerPosition(corner.corner);
      RawAppearance<double> appearance;
      if (!Appear(fixed, state.camera.data(), x_C, &appearance)) continue;
      const double q = 1 - corner.slope / appearance.kappa;
      errors.push_back(DistanceOf(fixed, state.camera, q) / x_C.z() - 1);
      // dz / z of an error of 1/v.
      const double step = 1e-6;
      const double per_q =
          (DistanceOf(fixed, state.camera, q + step) - DistanceOf(fixed, state.camera, q - step)) /
          (2 * step * x_C.z());
      const double noise_sigma =
          noise.slope_scale[k] * corner.slope_sigma / appearance.kappa * per_q;
      variances.push_back(noise_sigma * noise_sigma / result.views[k].corners.size() +
                          std::pow(noise.depth_offset_sigma * per_q, 2));
    }
    if (errors.empty()) continue;
    view.relative_error = UpperMedian(errors);
    const double calibration =
        DistanceSigma(fixed, state.camera, *without.covariance, view.distance_m);
    view.sigma = std::sqrt(calibration * calibration + UpperMedian(variances));
    left_out.push_back(view);
  }
  return left_out;
}

}  // namespace prism
