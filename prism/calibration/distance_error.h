// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/calibration/calibrate.h"

namespace prism {

// Standard deviation of (z' - z) / z, where z' is the distance the calibrated camera finds for a
// point at z whose virtual depth is measured without error: what the calibration itself is worth.
// By first order. Precondition: the adjustment has a covariance.
double RelativeDistanceSigma(const CalibrationResult& result, double distance_m);

// The figures of the camera file with their standard deviations and correlations: f_L, b_L0, B (m),
// c_L (raw px), A0, A1, B0, B1. Same precondition.
struct NamedFigure {
  std::string name;
  std::string unit;
  double value = 0;
  double sigma = 0;
  bool held = false;
};
struct CameraFigures {
  std::vector<NamedFigure> figures;
  Eigen::MatrixXd correlations;  // 0 for figures that were held
};
CameraFigures FiguresOf(const CalibrationResult& result);

// A view that took no part: its distance by depth, with the camera that all other views make,
// against its distance by the board's size in the image.
struct LeftOutView {
  std::string name;
  double distance_m = 0;      // by the board
  double relative_error = 0;  // of the median over its corners: distance by depth / by board - 1
  double sigma = 0;           // stated: calibration, depth offset of a view, noise of its corners
};
std::vector<LeftOutView> LeaveOneOut(const CalibrationBoard& board,
                                     const CalibrationResult& result);

}  // namespace prism
