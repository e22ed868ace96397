// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>

#include "prism/solver/block.h"

namespace prism {

// Blocks of parameters and the factors that tie them: the one list that the solver, the
// marginalisation, the test for outliers, the variance factors and the Jacobian check work on.
// Knows nothing of cameras and images.
//
// The graph holds copies of the values, one block behind the other in the order they were added:
// Ceres orders blocks by address, so that a result does not depend on where the heap put them.
// First all blocks are added, then factors.
class FactorGraph {
 public:
  struct Block {
    BlockKindPtr kind;
    int owner = kRunOwner;                   // id of the keyframe or number of the point
    const double* first_estimate = nullptr;  // null: Jacobians are evaluated at the values
    bool is_constant = false;
    int offset = 0;  // of the values in the graph's storage

    bool IsPoint() const { return kind->lifetime == BlockLifetime::kPoint; }
  };

  // A factor as it is added.
  struct NewFactor {
    std::unique_ptr<const ceres::CostFunction> cost;
    const ceres::LossFunction* loss = nullptr;  // null: squares; must outlive the graph
    // Factors of a term that are judged together (OutlierRule), the term's own number.
    int group = 0;
    // The cost evaluates its Jacobians at the first estimates itself.
    bool keeps_first_estimates = false;
    // Of the marginalisation prior: its Jacobian is the same everywhere, so that nothing is lost
    // when it is taken into the next prior, which happens at every marginalisation, whatever
    // leaves. Whoever adds such a factor must not add it again afterwards.
    bool is_linear = false;
  };

  struct Factor {
    const ceres::CostFunction* cost;
    const ceres::LossFunction* loss;
    int term;  // what it is for: number of the term that added it
    int group;
    bool keeps_first_estimates;
    bool is_linear;
    int first_block;  // in block_indices
    int num_blocks;
  };

  FactorGraph() = default;
  FactorGraph(const FactorGraph&) = delete;
  FactorGraph& operator=(const FactorGraph&) = delete;

  // The number of the block. `first_estimate` must outlive the graph.
  int AddBlock(BlockKindPtr kind,
               int owner,
               const double* values,
               const double* first_estimate = nullptr);
  void SetConstant(int block) { blocks_[block].is_constant = true; }

  // Factors that follow belong to this term.
  void BeginTerm(int term) { term_ = term; }
  // The number of the factor. `blocks` in the order of the cost's parameters.
  int AddFactor(NewFactor factor, const std::vector<int>& blocks);
  void ClearFactors();
  // Called with the values in place before factors are evaluated there.
  void AddCallback(std::shared_ptr<ceres::EvaluationCallback> callback) {
    callbacks_.push_back(std::move(callback));
  }

  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<Factor>& factors() const { return factors_; }
  // Numbers of a factor's blocks, `num_blocks` of them.
  const int* BlocksOf(const Factor& factor) const {
    return block_indices_.data() + factor.first_block;
  }

  double* values(int block) { return values_.data() + blocks_[block].offset; }
  const double* values(int block) const { return values_.data() + blocks_[block].offset; }

  // Brings what factors share up to date with the values.
  void PrepareForEvaluation(bool evaluate_jacobians = true, bool new_evaluation_point = true) const;

 private:
  std::vector<Block> blocks_;
  std::vector<double> values_;
  std::vector<Factor> factors_;
  std::vector<int> block_indices_;
  std::vector<std::unique_ptr<const ceres::CostFunction>> costs_;
  std::vector<std::shared_ptr<ceres::EvaluationCallback>> callbacks_;
  int term_ = 0;
};

}  // namespace prism
