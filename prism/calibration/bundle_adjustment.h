// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prism/board/calibration_board.h"
#include "prism/calibration/camera_model.h"
#include "prism/calibration/corner_observation.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/geometry/se3.h"

namespace prism {

// All that is adjusted.
struct CalibrationState {
  CameraParameters camera{};
  std::vector<SE3> cam_from_board;    // one a view
  std::vector<double> depth_offsets;  // error of 1/v that a view's corners share
};

// What the observations are worth, over what they claim; estimated from the residuals. Corners of a
// far, a blurred or an oblique board are worth less than others: each view has its own.
struct CalibrationNoise {
  std::vector<double> px_scale;        // one a view
  std::vector<double> slope_scale;     // one a view
  double depth_offset_sigma = 0.0005;  // of 1/v, from view to view

  explicit CalibrationNoise(size_t num_views = 0)
      : px_scale(num_views, 1), slope_scale(num_views, 1) {}
};

using ParameterFlags = std::array<bool, kNumCameraParameters>;

struct AdjustmentOptions {
  ParameterFlags held{};  // camera parameters that stay as they are
  int max_iterations = 100;
  bool estimate_noise = true;
};

struct AdjustmentResult {
  bool converged = false;
  double cost = 0;       // half the sum of squared normalised residuals, robust
  double px_rms = 0;     // of a corner's position in the micro image, raw px
  double depth_rms = 0;  // of 1/v
  int corners = 0;
  // Of the camera parameters, with all views' poses and offsets unknown; rows and columns of held
  // ones are 0. Nothing where the observations do not determine all of them.
  std::optional<Eigen::Matrix<double, kNumCameraParameters, kNumCameraParameters>> covariance;
};

// Minimises, robustly (Huber), over the camera, the poses and the offsets:
//   (px_predicted - px) / sigma_px                          2 residuals a corner
//   (slope_predicted(delta_k) - slope) / sigma_slope        1
//   delta_k / sigma_delta                                   1 a view
// and brings the standard deviations into agreement with the residuals (variance components).
// Views without corners are ignored. Precondition: state and noise have as many views.
AdjustmentResult AdjustCalibration(const CalibrationBoard& board,
                                   const std::vector<BoardView>& views,
                                   const FixedFigures& fixed,
                                   const AdjustmentOptions& options,
                                   CalibrationNoise* noise,
                                   CalibrationState* state);

}  // namespace prism
