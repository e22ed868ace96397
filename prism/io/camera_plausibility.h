// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/camera/micro_lens_grid.h"
#include "prism/camera/plenoptic_camera.h"

namespace prism {

// Figures that are numbers, but not those of a camera: lengths in metres where a file has
// millimetres, a principal point of another image, a digit lost. Each is checked by itself and
// against the others; an InputError names the one that looks wrong. Precondition: IsValid.
//
// Of any camera: 0.3 to 100 um a pixel, 1 to 2000 mm of focal length, the principal point in the
// image, a field of view of 5 to 120 degrees across the diagonal. With a micro-lens grid: B is 0.8
// to 30 pitches, and the grid's own.
void RequirePlausibleCamera(const PlenopticCamera& camera, const std::string& path);

// The principal point in the image, a field of view of 5 to 170 degrees.
void RequirePlausiblePinhole(const PinholeCamera& camera, const std::string& path);

// Of a camera with metric depth: the virtual depth of infinity is 1.2 to 20.
void RequirePlausibleInfinity(const PlenopticCamera& camera, const std::string& path);

// Pitch, offset, border and base vectors of micro lenses as they are made, depth ranges that are
// ranges.
void RequirePlausibleGrid(const MicroLensGrid& grid, const std::string& path);

}  // namespace prism
