// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/board/calibration_board.h"
#include "prism/calibration/calibrate.h"
#include "prism/calibration/distance_error.h"

namespace prism {

// What is said of a calibration.
struct CalibrationReport {
  std::string text;  // for the command line
  CameraFigures figures;
  std::vector<LeftOutView> left_out;
  double left_out_rms_in_sigmas = 0;
};

CalibrationReport MakeCalibrationReport(const CalibrationBoard& board,
                                        const CalibrationResult& result);

// calibration.json, observations.csv, distance_error.svg and .png, report.html.
void WriteCalibrationReport(const std::string& folder,
                            const CalibrationBoard& board,
                            const CalibrationResult& result,
                            const CalibrationReport& report);

}  // namespace prism
