// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "prism/image/patch.h"
#include "prism/scene/frame.h"
#include "prism/scene/frame_state.h"
#include "prism/solver/block.h"

namespace prism {

// A scene point, hosted by the keyframe it was selected in.
struct Point {
  int id = 0;  // rising, one for each point the window ever had
  PhotometricPatch patch;
  double rho = 0;  // metric inverse depth in the host frame, 1/m
  // Standard deviation of rho, poses held, from all that is known of the point; 0: not known
  // yet, and the depth is taken as it is.
  double rho_sigma = 0;
  // Measured inverse virtual depth and its standard deviation, larger than that of the frame where
  // other points share its error (NumSharingDepth); sigma 0 = no measurement.
  double w_measured = 0;
  double w_sigma = 0;
  double depth_sharing = 1;  // how many measurements stand for one (NumSharingDepth)
  // Keyframes (by id) whose residual was found to be an outlier (occlusion, reflection).
  std::vector<int> outlier_targets;
  // Keyframes whose measured depth was one, where they see the point.
  std::vector<int> depth_outlier_targets;
};

// A pixel that may become a point: its depth is a Gaussian over inverse depth, from the measured
// virtual depth or wide open, and narrowed down by matches in the frames that follow.
struct Candidate {
  PhotometricPatch patch;
  double rho = 0;           // 1/m
  double rho_variance = 0;  // 1/m^2
  double w_measured = 0;    // as in Point
  double w_sigma = 0;
  double depth_sharing = 1;  // as in Point
  int matches = 0;           // frames it was found in
  int failures = 0;          // frames in a row it should have been found in and was not
};

// A frame of the sliding window. Nodes do not move while the window holds them: patches are
// pointed to by residuals.
struct Keyframe {
  int id = 0;  // rising with time
  std::shared_ptr<const LightFieldFrame> frame;
  FrameState state;
  // Set once the frame shares the marginalisation prior: where its Jacobians are evaluated.
  std::optional<FrameState> first_estimate;
  std::vector<StateBlock> states;  // of terms that add some to each keyframe
  std::vector<std::unique_ptr<Point>> points;
  std::vector<Candidate> candidates;
};

}  // namespace prism
