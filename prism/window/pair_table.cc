// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/pair_table.h"

#include <glog/logging.h>

namespace prism {

PairTable::PairTable(const Window& window, bool first_estimates)
    : pairs_(window.keyframes.size() * window.keyframes.size()) {
  for (const auto& keyframe : window.keyframes) {
    states_.push_back(&keyframe->state);
    const bool has_first_estimate = first_estimates && keyframe->first_estimate;
    first_estimates_.push_back(has_first_estimate ? &*keyframe->first_estimate : nullptr);
  }
  Update();
}

PairTable::PairTable(const Window& window,
                     const std::vector<FrameState>& states,
                     bool first_estimates)
    : PairTable(window, first_estimates) {
  CHECK_EQ(states.size(), states_.size());
  for (size_t i = 0; i < states.size(); ++i) states_[i] = &states[i];
  Update();
}

void PairTable::Update() {
  const size_t size = states_.size();
  for (size_t i = 0; i < size; ++i) {
    for (size_t j = 0; j < size; ++j) {
      if (i == j) continue;
      pairs_[i * size + j].Update(
          *states_[i], *states_[j], first_estimates_[i], first_estimates_[j]);
    }
  }
}

void PairTable::PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) {
  if (new_evaluation_point) Update();
}

}  // namespace prism
