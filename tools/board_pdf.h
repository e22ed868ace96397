// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/board/calibration_board.h"

namespace prism {

// A page to print in its own size: the board with a margin of half a square, a line that says what
// it is, and a ruler of 100 mm to hold a ruler against. Written under a temporary name and renamed.
// Throws InputError if that cannot be done. Precondition: the board is valid.
void WriteBoardPdf(const std::string& path, const CalibrationBoard& board);

}  // namespace prism
