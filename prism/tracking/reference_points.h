// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "prism/scene/window.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

// A point as another frame sees it; nothing where it does not. The frame it is seen in does not
// tell whether it is hidden there.
std::optional<ReferencePoint> TransferPoint(const PlenopticProjection& camera,
                                            const RigidMotion& target_from_reference,
                                            const ReferencePoint& point);

// The points of all keyframes of the window as the keyframe `reference` (one of them) sees them.
std::vector<ReferencePoint> MakeReferencePoints(const Window& window, const Keyframe& reference);

}  // namespace prism
