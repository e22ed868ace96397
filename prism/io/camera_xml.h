// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/camera/plenoptic_camera.h"

namespace prism {

// The XML formats behind camera_file.h. They read what the elements say, without judging the
// figures; InputError on a missing element or one that is no number. Elements that are not known
// are logged and passed over: both formats are other people's.

// LiFCal CameraModel.xml, focused_scale 2 (raw image twice the focused one).
PlenopticCamera ReadLifcalXml(const std::string& path);
std::string LifcalXml(const PlenopticCamera& camera);

// Raytrix RayCalibData.
MicroLensGrid ReadRaytrixXml(const std::string& path);
std::string RaytrixXml(const MicroLensGrid& grid);

}  // namespace prism
