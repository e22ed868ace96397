// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/scene/window.h"

namespace prism {

// Fraction of the window's points that a frame at a pose measures where they are predicted to be:
// measured 1/v within three standard deviations (0.004 at the least) of the predicted one. 0 if
// fewer than 30 points meet a measurement. A wrong pose that happens to look right fails this.
double DepthAgreement(const Window& window,
                      const LightFieldFrame& frame,
                      const SE3& cam_from_world);

}  // namespace prism
