// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "prism/geometry/se3.h"

namespace prism {

struct StampedPose {
  int64_t time_ns = 0;
  SE3 world_from_cam;
};

// Poses with strictly increasing times.
using Trajectory = std::vector<StampedPose>;

}  // namespace prism
