// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/export/export_run.h"
#include "prism/export/ply.h"

namespace prism {

struct FusionOptions {
  int max_distance = 4;     // keyframes before and after that are asked
  int min_agreeing = 2;     // of them
  double max_error = 2;     // of two depths that agree, in standard deviations of their difference
  double max_sigma = 0.05;  // of what comes out, relative to the depth
};

// The depth maps of all keyframes in one cloud. A pixel's depth is believed where neighbouring
// keyframes measure the same surface; more of them that see through it speak against it. Agreeing
// measurements are averaged by their variances, and are not taken again. The standard deviation
// that comes out knows nothing of what the maps have in common (camera, poses).
std::vector<OrientedPoint> FuseDepth(const ExportRun& run, const FusionOptions& options = {});

// FOLDER/points_dense.ply with FuseDepth; returns one line about it.
std::string WriteDensePly(const std::string& folder, const ExportRun& run);

}  // namespace prism
