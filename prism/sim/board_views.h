// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/camera/plenoptic_camera.h"
#include "prism/sim/motion.h"

namespace prism {

struct BoardViewOptions {
  int num_views = 20;
  double rate_hz = 15;
  uint64_t seed = 1;
  double max_tilt_deg = 40;  // of the board against the image plane

  bool IsValid(std::string* error) const;
};

// Pictures somebody takes to calibrate a camera: the flat target at path.target, which faces
// path.position and is 2 path.extent wide, tilted and turned, anywhere in the image, from where it
// fills the image to where it is a sixth of it (evenly spaced in inverse distance, in random
// order). The camera stands still while a picture is taken.
CameraMotion GenerateBoardViews(const BoardViewOptions& options,
                                const PlenopticCamera& camera,
                                const SimPath& path);

}  // namespace prism
