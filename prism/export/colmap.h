// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/export/export_run.h"

namespace prism {

// FOLDER/colmap: a model of COLMAP, as text (cameras.txt, images.txt, points3D.txt), and the
// keyframes' images in images/. One PINHOLE camera, where WorldFromPinhole puts it;
// metres; COLMAP's pixel coordinates begin at the corner of the first pixel, ours at its centre.
// Points have the observations of FindTracks and stand where these meet (Triangulate), which is
// what other software takes for granted; those that only their host shows are left out. Returns one
// line about it. Throws InputError if a file cannot be written.
std::string WriteColmap(const std::string& folder, const ExportRun& run);

}  // namespace prism
