// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "prism/camera/frame_state.h"
#include "prism/image/patch.h"
#include "prism/scene/frame.h"

namespace prism {

// A scene point, hosted by the keyframe it was selected in.
struct Point {
  PhotometricPatch patch;
  double rho = 0;  // metric inverse depth in the host frame, 1/m
  // Measured inverse virtual depth and its standard deviation; sigma 0 = no measurement.
  double w_measured = 0;
  double w_sigma = 0;
  // Keyframes (by id) whose residual was found to be an outlier (occlusion, reflection).
  std::vector<int> outlier_targets;
};

// A frame of the sliding window. Nodes do not move while the window holds them: Ceres keeps
// pointers to `state` and to each point's `rho`.
struct Keyframe {
  int id = 0;  // rising with time
  std::shared_ptr<const LightFieldFrame> frame;
  FrameState state;
  // Set once the frame shares the marginalisation prior: where its Jacobians are evaluated.
  std::optional<FrameState> first_estimate;
  std::vector<std::unique_ptr<Point>> points;
};

}  // namespace prism
