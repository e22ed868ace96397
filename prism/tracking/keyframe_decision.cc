// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/keyframe_decision.h"

#include <cmath>

namespace prism {

bool KeyframeOptions::IsValid(std::string* error) const {
  if (max_translation_flow > 0 && max_flow > 0 && max_rotation > 0 && max_log_gain > 0 &&
      max_rms_ratio > 1 && min_visible_fraction >= 0 && min_visible_fraction <= 1) {
    return true;
  }
  *error =
      "keyframe limits must be positive, the RMS ratio above 1 and the visible fraction in [0, 1]";
  return false;
}

bool NeedsKeyframe(const FrameAlignmentResult& alignment,
                   double first_rms,
                   int image_width,
                   int image_height,
                   const KeyframeOptions& options) {
  const double size = image_width + image_height;
  const double sum =
      std::sqrt(alignment.squared_translation_flow) / (options.max_translation_flow * size) +
      std::sqrt(alignment.squared_flow) / (options.max_flow * size) +
      RotationAngle(alignment.state.target_from_reference) / options.max_rotation +
      std::abs(alignment.state.a) / options.max_log_gain;
  const double seen = alignment.fit.visible_fraction * (1 - alignment.fit.outlier_fraction);
  return sum > 1 || seen < options.min_visible_fraction ||
         (first_rms > 0 && alignment.points.rms > options.max_rms_ratio * first_rms);
}

}  // namespace prism
