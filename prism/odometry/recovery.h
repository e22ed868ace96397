// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/scene/window.h"
#include "prism/tracking/tracker.h"

namespace prism {

struct RecoveryResult {
  TrackingResult tracking;              // of the keyframe that matched, or of the last one tried
  const Keyframe* reference = nullptr;  // that matched; null: none did
};

// Tries a frame against all keyframes of the window, newest first, until one matches within the
// limits, with the frame's own depths agreeing. `tracker` follows that one from then on; without a
// match it stays as it was.
RecoveryResult Recover(const FitLimits& limits,
                       const PlenopticCamera& camera,
                       const Window& window,
                       const LightFieldFrame& frame,
                       Tracker* tracker);

}  // namespace prism
