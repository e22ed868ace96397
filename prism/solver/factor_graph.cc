// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/factor_graph.h"

#include <utility>

#include <glog/logging.h>

namespace prism {

int FactorGraph::AddBlock(BlockKindPtr kind,
                          int owner,
                          const double* values,
                          const double* first_estimate) {
  CHECK(factors_.empty()) << "a block after factors: " << kind->name;
  Block block;
  block.owner = owner;
  block.first_estimate = first_estimate;
  block.offset = static_cast<int>(values_.size());
  values_.insert(values_.end(), values, values + kind->size);
  block.kind = std::move(kind);
  blocks_.push_back(std::move(block));
  return static_cast<int>(blocks_.size()) - 1;
}

int FactorGraph::AddFactor(NewFactor factor, const std::vector<int>& blocks) {
  const std::vector<int>& sizes = factor.cost->parameter_block_sizes();
  CHECK_EQ(sizes.size(), blocks.size());
  for (size_t i = 0; i < blocks.size(); ++i) {
    CHECK_EQ(sizes[i], blocks_[blocks[i]].kind->size) << blocks_[blocks[i]].kind->name;
  }
  costs_.push_back(std::move(factor.cost));
  factors_.push_back({costs_.back().get(),
                      factor.loss,
                      term_,
                      factor.group,
                      factor.keeps_first_estimates,
                      factor.is_linear,
                      static_cast<int>(block_indices_.size()),
                      static_cast<int>(blocks.size())});
  block_indices_.insert(block_indices_.end(), blocks.begin(), blocks.end());
  return static_cast<int>(factors_.size()) - 1;
}

void FactorGraph::ClearFactors() {
  factors_.clear();
  block_indices_.clear();
  costs_.clear();
}

void FactorGraph::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) const {
  for (const auto& callback : callbacks_) {
    callback->PrepareForEvaluation(evaluate_jacobians, new_evaluation_point);
  }
}

}  // namespace prism
