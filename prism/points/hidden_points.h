// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>

#include "prism/scene/window.h"

namespace prism {

// Before a new keyframe is optimised: points that do not fit it are not looked for in it
// (Point::outlier_targets). Those are `misfits` (Point::id), found when it was tracked, points that
// were hidden in the keyframe before and are not clearly seen again at the states as they are, and
// points that are clipped there (IsClipped).
void MarkHiddenPoints(const std::set<int>& misfits, Window* window);

}  // namespace prism
