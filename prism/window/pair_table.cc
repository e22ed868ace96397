// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/pair_table.h"

namespace prism {

PairTable::PairTable(const Window& window, bool first_estimates)
    : window_(window),
      first_estimates_(first_estimates),
      pairs_(window.keyframes.size() * window.keyframes.size()) {
  Update();
}

void PairTable::Update() {
  const size_t size = window_.keyframes.size();
  const auto first_estimate = [&](const Keyframe& keyframe) {
    return first_estimates_ && keyframe.first_estimate ? &*keyframe.first_estimate : nullptr;
  };
  for (size_t i = 0; i < size; ++i) {
    for (size_t j = 0; j < size; ++j) {
      if (i == j) continue;
      const Keyframe& host = *window_.keyframes[i];
      const Keyframe& target = *window_.keyframes[j];
      pairs_[i * size + j].Update(
          host.state, target.state, first_estimate(host), first_estimate(target));
    }
  }
}

void PairTable::PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) {
  if (new_evaluation_point) Update();
}

}  // namespace prism
