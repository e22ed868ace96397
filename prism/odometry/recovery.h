// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/scene/window.h"
#include "prism/tracking/tracker.h"

namespace prism {

// What a match after a loss must show beyond that of an ordinary frame: nothing but the images
// speaks for it, and a wrong pose spoils the map.
struct RecoveryOptions {
  double max_rms_ratio = 1.5;         // RMS over the median of the frames tracked before
  double max_outlier_fraction = 0.2;  // of the samples
  double min_visible_fraction = 0.5;  // of the samples
  double max_log_gain = 0.3;          // |a - a of the keyframe|
  double min_depth_agreement = 0.8;   // see DepthAgreement

  bool IsValid(std::string* error) const;
};

struct RecoveryResult {
  TrackingResult tracking;              // of the keyframe that matched, or of the last one tried
  const Keyframe* reference = nullptr;  // that matched; null: none did
};

// Tries a frame against all keyframes of the window, newest first. `tracker` follows the one that
// matched from then on; without a match it stays as it was.
RecoveryResult Recover(const RecoveryOptions& options,
                       const PlenopticCamera& camera,
                       const Window& window,
                       const LightFieldFrame& frame,
                       Tracker* tracker);

}  // namespace prism
