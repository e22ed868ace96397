// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/pair_table.h"

#include <utility>

#include <glog/logging.h>

namespace prism {

PairTable::PairTable(std::vector<const double*> states,
                     std::vector<const FrameState*> first_estimates,
                     double residual_sigma)
    : states_(std::move(states)),
      first_estimates_(std::move(first_estimates)),
      pairs_(states_.size() * states_.size()) {
  CHECK_EQ(states_.size(), first_estimates_.size());
  for (FramePair& pair : pairs_) pair.inverse_sigma = 1 / residual_sigma;
  PairTable::PrepareForEvaluation(true, true);
}

void PairTable::PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) {
  if (!new_evaluation_point) return;
  const size_t size = states_.size();
  std::vector<FrameState> states;
  for (const double* values : states_) states.emplace_back(values);
  for (size_t i = 0; i < size; ++i) {
    for (size_t j = 0; j < size; ++j) {
      if (i == j) continue;
      pairs_[i * size + j].Update(states[i], states[j], first_estimates_[i], first_estimates_[j]);
    }
  }
}

}  // namespace prism
