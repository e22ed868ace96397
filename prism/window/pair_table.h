// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ceres/evaluation_callback.h>

#include "prism/residual/frame_pair.h"
#include "prism/window/window.h"

namespace prism {

// The relative geometry of every ordered pair of keyframes in the window, brought up to date once
// per evaluation.
class PairTable : public ceres::EvaluationCallback {
 public:
  // `first_estimates`: Jacobians of frames that have one are evaluated there. The states are read
  // from `states` (one a keyframe, in their order), or from the keyframes themselves.
  PairTable(const Window& window, bool first_estimates);
  PairTable(const Window& window, const std::vector<FrameState>& states, bool first_estimates);

  // Addresses stay valid as long as the table.
  const FramePair& pair(size_t host_index, size_t target_index) const {
    return pairs_[host_index * states_.size() + target_index];
  }
  void Update();

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

 private:
  std::vector<const FrameState*> states_;
  std::vector<const FrameState*> first_estimates_;  // null: none
  std::vector<FramePair> pairs_;
};

}  // namespace prism
