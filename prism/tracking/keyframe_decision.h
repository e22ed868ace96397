// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/tracking/frame_alignment.h"

namespace prism {

struct KeyframeOptions {
  // Each cause alone makes a keyframe when it reaches its limit; fractions of them add up.
  double max_translation_flow = 0.04;  // RMS flow by translation, fraction of width + height
  double max_flow = 0.07;              // RMS flow of the whole motion, fraction of width + height
  double max_rotation = 0.3;           // rad
  double max_log_gain = 0.3;           // |relative a|
  double min_visible_fraction = 0.6;   // of the reference's points, that fit
  double max_rms_ratio = 2;            // RMS over that of the first frame after the keyframe

  bool IsValid(std::string* error) const;
};

// Decides whether the tracked frame becomes a keyframe (DSO, Section 3.1: flow, flow by translation
// and brightness change, here with rotation and visibility). `first_rms` is the alignment RMS of
// the first frame tracked on the current keyframe (0: this is it).
bool NeedsKeyframe(const FrameAlignmentResult& alignment,
                   double first_rms,
                   int image_width,
                   int image_height,
                   const KeyframeOptions& options);

}  // namespace prism
