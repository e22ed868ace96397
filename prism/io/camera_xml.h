// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "prism/camera/plenoptic_camera.h"

namespace prism {

// The XML formats behind camera_file.h. They read what the elements say, without judging the
// figures; InputError on a missing element or one that is no number. Elements that are not known
// are logged and passed over: both formats are other people's. In both, an element isReal or
// IsKepler (true or false) tells the MicroLensMode.

// LiFCal CameraModel.xml, focused_scale 2 (raw image twice the focused one).
PlenopticCamera ReadLifcalXml(const std::string& path);
std::string LifcalXml(const PlenopticCamera& camera);

// Raytrix RayCalibData; `mode` becomes what the file says of it, if it does.
MicroLensGrid ReadRaytrixXml(const std::string& path, std::optional<MicroLensMode>* mode);
std::string RaytrixXml(const MicroLensGrid& grid);

}  // namespace prism
