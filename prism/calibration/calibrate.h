// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/board/calibration_board.h"
#include "prism/calibration/bundle_adjustment.h"
#include "prism/calibration/corner_observation.h"
#include "prism/camera/plenoptic_camera.h"

namespace prism {

enum class DistortionModel {
  kAuto,    // those that the pictures tell
  kNone,    // none: those of the camera it starts with stay
  kRadial,  // A0, A1
  kFull,    // A0, A1, B0, B1
};
bool ParseDistortionModel(const std::string& text, DistortionModel* model);

struct CalibrateOptions {
  // f_L of the camera it starts with is what is engraved on the lens: taken where the pictures do
  // not tell it, or always.
  bool focal_length_is_known = false;
  bool hold_focal_length = false;
  bool hold_sensor_distance = false;  // B likewise
  // B of the camera it starts with is the maker's or was calibrated before. It is found anew, but
  // where it comes out another one the board's squares may have another size than given (B goes
  // with one over it), which nothing else tells: that is a finding.
  bool sensor_distance_is_known = false;
  DistortionModel distortion = DistortionModel::kAuto;
};

struct CornerResidual {
  int corner = 0;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();        // where it was seen, raw px
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // predicted minus seen, raw px
  double inverse_depth_residual = 0;                   // of 1/v, the view's offset taken off
};

// A picture, as the calibrated camera sees it.
struct CalibratedView {
  std::string name;
  std::vector<CornerResidual> residuals;
  int corners = 0;
  double distance_m = 0;    // of the middle of the corners, along the axis
  double tilt_deg = 0;      // of the board against the sensor
  double px_rms = 0;        // raw px, in the micro image
  double depth_rms = 0;     // of 1/v, the view's offset taken off
  double depth_offset = 0;  // of 1/v
};

struct CalibrationResult {
  // Empty: the camera may be used. Otherwise why not, and which pictures are missing.
  std::string problem;
  std::vector<std::string> findings;  // what was held and why, and what was left out

  PlenopticCamera camera;
  ParameterFlags held{};
  AdjustmentResult adjustment;
  CalibrationNoise noise;
  CalibrationState state;
  std::vector<BoardView> views;  // what was used: without outliers
  std::vector<CalibratedView> summaries;
};

// A camera's f_L, b_L0, B, principal point and distortion from pictures of a board (bundle
// adjustment). `start`: its mode, pixel size, grid and whether Eq. (8) applies stay as they are;
// f_L and B are where the search starts.
//
// What the pictures do not determine is held and reported (principal point, distortion; f_L where
// it is known) or is a problem: f_L without tilted boards, b_L0 against B at one distance alone.
// Pictures of another camera or focus (FindStrangers) are left out and reported, or are a problem
// if they are more than a fifth.
CalibrationResult Calibrate(const CalibrationBoard& board,
                            std::vector<BoardView> views,
                            const PlenopticCamera& start,
                            const CalibrateOptions& options);

}  // namespace prism
