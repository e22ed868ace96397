// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace prism {

// A board's corner seen in one micro image, as other calibrators publish them.
struct MicroImageCorner {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();              // raw px
  Eigen::Vector2d micro_image_px = Eigen::Vector2d::Zero();  // centre of the micro image, raw px
  int cluster = 0;  // the same for all images of one corner in one picture
  int frame = 0;
};

// Two CSV files with a header line: corners with columns k, l (index of the micro image), u, v (raw
// px), cluster, frame; centres with columns k, l and u, v (or x, y), raw px. Columns in any order,
// others are passed over. Throws InputError (file and line) on a file that cannot be read, a column
// that is missing, what is no number (a whole one but for u and v), a corner whose micro image has
// no centre or is more than a micro image away from it, fewer than two centres and no corners.
std::vector<MicroImageCorner> ReadMicroImageCorners(const std::string& corners_path,
                                                    const std::string& centers_path);

}  // namespace prism
