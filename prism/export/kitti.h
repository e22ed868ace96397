// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/export/export_run.h"

namespace prism {

// FOLDER/trajectory_kitti.txt: the 12 numbers of [R | t] of world_from_cam row by row, a line a
// tracked frame; and trajectory_kitti_times.txt, seconds. Returns one line about it. Throws
// InputError if a file cannot be written.
std::string WriteKitti(const std::string& folder, const ExportRun& run);

}  // namespace prism
