// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/export/export_run.h"

namespace prism {

// FOLDER/run.mcap, with the schemas of Foxglove, for Foxglove and Rerun:
//   /tf           FrameTransform     world -> camera of every tracked frame, and camera ->
//                                    front_focal_point, where the pinhole of the images stands
//   /image        CompressedImage    keyframes
//   /calibration  CameraCalibration  beside each
//   /points       PointCloud         the map, in the world: position, colour, sigma
// Returns one line about it. Throws InputError if the file cannot be written, and for times before
// 1970, which MCAP does not have.
std::string WriteMcap(const std::string& folder, const ExportRun& run);

}  // namespace prism
