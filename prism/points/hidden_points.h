// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>

#include "prism/scene/window.h"

namespace prism {

// Before a new keyframe is optimised: points that do not fit it are not looked for in it
// (Point::outlier_targets). Of points that were hidden in the keyframe before, or are clipped in
// this one (IsClipped), those are the ones not clearly seen at the states as they are; of the
// others the `misfits` (Point::id), found when the keyframe was tracked.
void MarkHiddenPoints(const std::set<int>& misfits, Window* window);

}  // namespace prism
