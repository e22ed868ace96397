// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "prism/solver/factor_graph.h"

namespace prism {

// The cost of a graph as a function of the blocks that are not points: wherever they are, each
// point takes the value at which its factors cost least (variable projection; G. Golub, V. Pereyra
// 1973). Points are one number each and see each other only through the other blocks, so that this
// is done point by point.
//
// Work is split into chunks of points whose sums are added in their order: results do not depend on
// the number of threads. Threads are those of the TBB arena it is called in.
class ReducedProblem {
 public:
  // A point is at its minimum if a step promises to lower its cost by less than `tolerance` of it.
  // The graph must outlive it and keep its factors; values of its blocks may change. Points that
  // cannot be eliminated, constant ones aside, are among the other blocks: those of more than one
  // number, and all but one of those that share a factor.
  ReducedProblem(FactorGraph* graph, double tolerance);
  ~ReducedProblem();

  // The blocks it is a function of: neither constant nor eliminated, with a factor.
  const std::vector<int>& blocks() const { return blocks_; }
  int TangentSize() const { return tangent_size_; }

  // Of the cost, over the tangent spaces of blocks() one behind the other. H is that of Gauss and
  // Newton with the losses' weights, points eliminated (Schur complement).
  struct Linearization {
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
  };

  // The cost where the graph's blocks are; the graph has to be prepared there. Points start from
  // where the last linearisation had them or, if this is the state of the last call
  // (`is_new_state` false), from where they were then. `linearization` may be null.
  double Evaluate(bool is_new_state, Linearization* linearization);

  // Cost of the first evaluation with the points as they were.
  double initial_cost() const { return initial_cost_; }

  // Puts the points to where the last linearisation had them.
  void StorePoints();

 private:
  struct EliminatedPoint {
    int block;
    std::vector<int> factors;
    double linearized, last;  // its values
  };
  struct Chunk;

  std::vector<bool> FindEliminated() const;
  void AssignColumns(const std::vector<bool>& is_eliminated);
  void EvaluateChunk(int index, bool is_new_state, bool linearize, Chunk* chunk);
  void ReduceToTangent(const Eigen::MatrixXd& H,
                       const Eigen::VectorXd& g,
                       Linearization* linearization) const;

  FactorGraph* graph_;
  double tolerance_;
  std::vector<std::unique_ptr<ceres::CostFunction>> wrapped_;
  std::vector<const ceres::CostFunction*> costs_;  // of each factor
  std::vector<EliminatedPoint> points_;
  std::vector<int> other_factors_;  // that tie no eliminated point
  std::vector<int> blocks_;
  std::vector<int> column_;  // of each block among the stored numbers of blocks_; -1: none
  int stored_size_ = 0, tangent_size_ = 0;
  double initial_cost_ = -1;
};

}  // namespace prism
