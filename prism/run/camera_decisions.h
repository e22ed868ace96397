// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/run/raw_input.h"
#include "prism/scene/frame.h"

namespace prism {

// Completes the camera and white image of a raw input by what its images tell, and says what it
// found in grid_report:
//
// 1. the grid, refined on the white image, or on `frames` where there is none; where they show it
//    only roughly, the refined one, the file's and that turned the other way are compared by the
//    information of the first frame's depths;
// 2. the mode: the other one, with a warning, where hardly any lenses agree and in that one they
//    do;
// 3. the vignetting, found on the frames if `find_vignetting`;
// 4. the order of lens types 1 and 2, by the sharpness of the focused first frame.
//
// `grid_path` is for messages, `frames` are some of the sequence, its first one first. Throws
// InputError for a grid whose pitch does not fit.
void DecideCamera(const std::string& grid_path,
                  const std::vector<RawFrame>& frames,
                  bool find_vignetting,
                  RawInput* input);

}  // namespace prism
