// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/io/camera_file.h"

namespace prism {

// The native camera format behind camera_file.h. Reads what the keys say, without judging the
// figures; InputError on a key that is missing, unknown, or not of its type.
AnyCamera ReadCameraYaml(const std::string& path);

std::string CameraYaml(const PlenopticCamera& camera);
std::string CameraYaml(const PinholeCamera& camera);

}  // namespace prism
