// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/export/export_run.h"

namespace prism {

// FOLDER/nerfstudio: transforms.json with the keyframes' images, their measured depth and the
// sparse points, as nerfstudio and Instant-NGP read it. The camera is the pinhole of
// WorldFromPinhole; its axes are OpenGL's (x right, y up, looking along -z), the world is ours, in
// metres. Depth is measured along the axis from that pinhole, in millimetres, 16 bits, 0 = none.
// Returns one line about it. Throws InputError if a file cannot be written.
std::string WriteNerfstudio(const std::string& folder, const ExportRun& run);

}  // namespace prism
