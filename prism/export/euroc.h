// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/export/export_run.h"

namespace prism {

// FOLDER/trajectory_euroc.csv: `timestamp_ns,px,py,pz,qw,qx,qy,qz` of world_from_cam, a line a
// tracked frame. Returns one line about it. Throws InputError if the file cannot be written.
std::string WriteEuroc(const std::string& folder, const ExportRun& run);

}  // namespace prism
