// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/board/calibration_board.h"
#include "prism/calibration/corner_observation.h"
#include "prism/io/micro_image_corners.h"

namespace prism {

// Views of the board from corners in single micro images: for each corner of a picture the line
// x_raw = p + m (c_I - mean of c_I) through its micro images, robustly (Eqs. (6) to (8), without
// knowing the camera). Corners in fewer than 4 micro images, or in images in a row, are left out.
// `cluster` numbers the board's corners row by row or column by column, from 0 or 1; where that
// does not fit a picture they are told by the lattice they make, for which all of the board's outer
// corners have to be seen. A picture that fits neither way has no corners in its view.
std::vector<BoardView> ViewsFromMicroImages(const CalibrationBoard& board,
                                            const std::vector<MicroImageCorner>& corners);

// True if the micro images are upside down: the slopes of most corners are above 1.
bool IsKeplerian(const std::vector<BoardView>& views);

}  // namespace prism
