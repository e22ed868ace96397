// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/io/raw_sequence.h"

namespace prism {

// A raw sequence with all that its processing needs.
struct RawInput {
  PlenopticCamera camera;  // with its micro-lens grid, refined
  cv::Mat white;           // empty: none
  std::optional<RawSequence> sequence;
  std::string grid_report;  // what the refinement of the grid found, one line
};

// Opens `folder` with the camera file, the grid file (empty: the camera file's own grid) and the
// white image (empty: the folder's white.png, else none). A grid is refined on the white image, or
// on the first frames where there is none. Throws InputError, also for a grid whose pitch does not
// fit the white image.
RawInput OpenRawInput(const std::string& folder,
                      const std::string& camera_path,
                      const std::string& grid_path,
                      const std::string& white_path);

}  // namespace prism
