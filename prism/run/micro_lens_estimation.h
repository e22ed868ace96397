// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/camera/plenoptic_camera.h"
#include "prism/run/raw_input.h"

namespace prism {

struct MicroLensEstimate {
  PlenopticCamera camera;  // the one given, with the grid found
  std::string report;      // a line a finding
};

// What a camera's own images tell of its micro lenses where there is no grid file. A white image
// (options.white_image, else the folder's) gives the lattice; raw frames (options.folder; may be
// empty if there is a white image) give it where there is none, and the mode, the number of lens
// types and what each is focused on (EstimateLensTypes). What the frames do not tell stays as in
// the camera file, one lens type, and the report says so. options.micro_lens_grid is not read.
//
// Throws InputError: unreadable input, neither a white image nor frames, or no lattice in them.
MicroLensEstimate EstimateMicroLenses(const RawInputOptions& options);

}  // namespace prism
