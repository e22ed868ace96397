// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/camera/plenoptic_camera.h"
#include "prism/run/sequence.h"

namespace prism {

// What a user did not say of a sequence and its folder holds: the camera (camera.yaml, else
// CameraModel.xml), and the micro-lens grid of raw frames (MLA_Calibration.xml) where the camera's
// file has none; whatever the case of the names. A line about each goes to `report`. The camera of
// RGB-D frames stays empty if the folder has no plenoptic one: StandInCamera is assumed. Throws
// InputError where a camera is needed and not found.
SequenceOptions CompleteFromFolder(const SequenceOptions& options,
                                   const std::string& format,
                                   std::vector<std::string>* report);

// The plenoptic camera that RGB-D frames are turned into those of where nothing else is said: a
// Raytrix R5 with a 16 mm lens (calib/raytrix_r5_16mm.yaml), without its grid.
PlenopticCamera StandInCamera();

}  // namespace prism
