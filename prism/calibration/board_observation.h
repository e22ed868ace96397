// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "prism/board/calibration_board.h"
#include "prism/calibration/board_detection.h"
#include "prism/calibration/corner_observation.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/image/image.h"
#include "prism/scene/frame.h"

namespace prism {

// The board in a totally focused image: corners there, and at each the measured inverse virtual
// depths around it (a plane fitted to them robustly, as far as half a square). `camera`: what the
// light field was computed with; any that resembles the true one will do. `dense`: inverse virtual
// depth that the image was focused with (0: unknown), which in images of virtual points says
// through which micro images a corner was seen; empty: the measured ones say it. In images of chief
// rays corners do not move with it, and their places are better known (FocusedImage). Corners
// without enough depth around are left out; the view is empty if there is no board.
BoardView ObserveBoard(const CalibrationBoard& board,
                       const PlenopticCamera& camera,
                       const LightFieldFrame& frame,
                       const ImageF& dense);

// The same of corners that are known.
BoardView ObserveCorners(const std::vector<DetectedCorner>& corners,
                         const PlenopticCamera& camera,
                         const LightFieldFrame& frame,
                         const ImageF& dense);

// Measured inverse virtual depth at a place of the focused image and its standard deviation, by a
// plane through those within `radius` px. Nothing if there are too few, or on one side only.
struct LocalDepth {
  double inverse_virtual_depth = 0;
  double sigma = 0;
};
std::optional<LocalDepth> FitLocalDepth(const LightFieldFrame& frame,
                                        const Eigen::Vector2d& px,
                                        double radius);

}  // namespace prism
