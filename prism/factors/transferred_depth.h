// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "prism/camera/projection.h"

namespace prism {

// What one frame's inverse virtual depth w = 1/v says of a point that another frame hosts.
struct TransferredDepth {
  double w;     // of the host
  double gain;  // d (w of the host) / d (w of the target)
};

// The point of the host's pixel, seen by the target at `w_target`: along its ray its depth in the
// target is linear in that of the host (Eqs. (2), (15), (17)). Points beyond infinity, as noise
// makes them, are no exception. Nothing where the target sees against the host's ray, or from
// behind the point.
std::optional<TransferredDepth> TransferDepth(const PlenopticProjection& camera,
                                              const RigidMotion& target_from_host,
                                              const Eigen::Vector2d& host_px,
                                              double w_target);

}  // namespace prism
