// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "prism/board/calibration_board.h"
#include "prism/calibration/bundle_adjustment.h"
#include "prism/calibration/corner_observation.h"
#include "prism/camera/plenoptic_camera.h"

namespace prism {

// b_L0 + B in raw px from the board's homographies (Zhang), for a camera whose focal length nobody
// knows. Nothing if no view has enough corners or all are parallel to the sensor.
std::optional<double> FocalLengthFromBoards(const CalibrationBoard& board,
                                            const std::vector<BoardView>& views,
                                            const PlenopticCamera& camera);

// Views that are not of the camera of most others, or not with its focus and zoom: of the lines
// v = v_inf + k / (z - f_L) through two views each, the one with the least median misfit over the
// views leaves them off by more than 1 % of v and 8 times that median. Distances are those of the
// board with `camera`; an f_L that is wrong stretches all of them alike. Indices, increasing; empty
// where fewer than 4 views have a pose, or no two lie far enough apart.
std::vector<int> FindStrangers(const CalibrationBoard& board,
                               const PlenopticCamera& camera,
                               const std::vector<BoardView>& views);

// Where the joint adjustment starts: poses of the board by PnP about the main lens' centre, where
// chief rays meet (image distance b_L0 + B, to which f_L of `camera` is near enough); then the line
// v = v_inf + k / (z - f_L) through all corners, robustly, for B = f_L^2 / k and v_inf. Views
// without a pose (fewer than 6 corners, or corners in a row) lose their corners. Nothing if no view
// is left or no camera with these depths exists. With one distance alone the line stays as in
// `camera`.
std::optional<CalibrationState> StartCalibration(const CalibrationBoard& board,
                                                 const PlenopticCamera& camera,
                                                 bool hold_sensor_distance,
                                                 std::vector<BoardView>* views);

}  // namespace prism
