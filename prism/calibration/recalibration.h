// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "prism/camera/plenoptic_camera.h"
#include "prism/odometry/options.h"
#include "prism/scene/frame.h"

namespace prism {

// The frames of a sequence, one after the other; nothing at its end.
using FrameStream = std::function<std::optional<LightFieldFrame>()>;

struct RecalibrationOptions {
  OdometryOptions odometry;
  double prior_sigma = 0.01;  // of 1/v: what b_L0 may be off by, at the measured depths
  int max_passes = 5;
  double converged = 0.2;  // standard deviations that b_L0 still moves by

  bool IsValid(std::string* error) const;
};

struct RecalibrationPass {
  double moved_m = 0;  // b_L0, in this pass
  double sigma_m = 0;  // standard deviation of b_L0; 0: nothing is known
  double tracked = 0;  // share of the frames
  int segments = 0;
};

struct RecalibrationResult {
  std::string problem;  // empty: the camera may be used; else why not
  PlenopticCamera camera;
  double moved_m = 0;  // b_L0, in all
  double sigma_m = 0;
  std::vector<RecalibrationPass> passes;
};

// b_L0 from a moving sequence of any scene with near and far parts, B and f_L held: what a turned
// focus ring or another temperature changes. The odometry runs with a lasting offset of measured
// 1/v among its states (DepthOffsetTerm); by photometry distances are known up to one factor, and
// virtual depth is a line over 1 / (z - f_L), whose intercept is v_inf (README, "Worth knowing").
// An offset of 1/v is an error of b_L0 to first order, at the depths that were measured; passes are
// repeated until none is left. A wrong B passes into the scale whatever the motion.
//
// `open` starts the sequence anew, for every pass. A problem: frames that cannot be tracked, or a
// scene that does not tell b_L0 from the scale (a wall).
RecalibrationResult Recalibrate(const PlenopticCamera& camera,
                                const RecalibrationOptions& options,
                                const std::function<FrameStream()>& open);

}  // namespace prism
