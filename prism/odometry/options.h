// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/factors/default_terms.h"
#include "prism/odometry/joining.h"
#include "prism/points/activation.h"
#include "prism/tracking/keyframe_decision.h"
#include "prism/tracking/tracker.h"
#include "prism/window/options.h"
#include "prism/window/retirement.h"

namespace prism {

struct OdometryOptions {
  ActivationOptions activation;
  TrackerOptions tracker;
  KeyframeOptions keyframe;
  WindowOptions window;
  RetirementOptions retirement;
  JoiningOptions joining;
  DefaultTermOptions default_terms;
  // Terms of the cost beside the default ones (docs/add_a_residual.md).
  TermList terms;
  // Photometric error beside the noise of the images, see NoiseModel; 0 to 255.
  double photometric_model_sigma = 3.5;
  int min_start_points = 100;  // with depth, to start a segment
  int max_lost_frames = 5;     // that show something, in a row; then a new segment is started
  // Standard deviations: a frame found again in the window farther than this from where motion
  // predicts it has to be verified both ways (VerifyMatch).
  double max_motion_distance = 5;
  int max_held_frames = 15;  // in a row, then frames that match no better are lost

  bool IsValid(std::string* error) const;
};

}  // namespace prism
