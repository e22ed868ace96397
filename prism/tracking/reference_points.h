// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/scene/window.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

// The points of all keyframes of the window as the keyframe `reference` (one of them) sees them.
std::vector<ReferencePoint> MakeReferencePoints(const Window& window, const Keyframe& reference);

}  // namespace prism
