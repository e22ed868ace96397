// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ceres/evaluation_callback.h>

#include "prism/factors/frame_pair.h"

namespace prism {

// FramePairs of every ordered pair of frames, brought up to date once per evaluation. The states
// are read where they lie; addresses of pairs stay valid as long as the table.
class PairTable : public ceres::EvaluationCallback {
 public:
  // One state a frame; `first_estimates` likewise, null where a frame has none.
  PairTable(std::vector<const double*> states,
            std::vector<const FrameState*> first_estimates,
            double residual_sigma);

  const FramePair& pair(size_t host_index, size_t target_index) const {
    return pairs_[host_index * states_.size() + target_index];
  }

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

 private:
  std::vector<const double*> states_;  // FrameState::kSize numbers each
  std::vector<const FrameState*> first_estimates_;
  std::vector<FramePair> pairs_;
};

}  // namespace prism
