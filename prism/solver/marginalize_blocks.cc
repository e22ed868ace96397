// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/marginalize_blocks.h"

#include <cmath>
#include <map>
#include <numeric>

#include <glog/logging.h>

#include "prism/solver/linearize.h"

namespace prism {
namespace {

using FactorList = std::vector<const FactorGraph::Factor*>;

// Which factors go into the prior.
FactorList SelectFactors(const FactorGraph& graph, const std::vector<bool>& is_leaving) {
  FactorList selected;
  for (const FactorGraph::Factor& factor : graph.factors()) {
    bool ties_leaving = factor.is_linear;
    bool ties_staying_point = false;
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph.BlocksOf(factor)[k];
      ties_leaving |= is_leaving[block];
      ties_staying_point |= graph.blocks()[block].IsPoint() && !is_leaving[block];
    }
    if (ties_leaving && !ties_staying_point) selected.push_back(&factor);
  }
  return selected;
}

// Leaving points that share a factor, directly or through others, are one group: they are
// eliminated together, each group by itself. Returns a representative of each block's group.
class PointGroups {
 public:
  explicit PointGroups(size_t num_blocks) : parent_(num_blocks) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Find(int block) {
    while (parent_[block] != block) block = parent_[block] = parent_[parent_[block]];
    return block;
  }
  void Join(int a, int b) { parent_[Find(b)] = Find(a); }

 private:
  std::vector<int> parent_;
};

// Accumulates linearised factors over blocks that are not points.
class PriorBuilder {
 public:
  PriorBuilder(const FactorGraph& graph, const FactorList& factors)
      : graph_(graph), column_(graph.blocks().size(), -1) {
    std::vector<bool> is_touched(graph.blocks().size(), false);
    for (const FactorGraph::Factor* factor : factors) {
      for (int k = 0; k < factor->num_blocks; ++k) is_touched[graph.BlocksOf(*factor)[k]] = true;
    }
    int size = 0;
    for (size_t i = 0; i < graph.blocks().size(); ++i) {
      const FactorGraph::Block& block = graph.blocks()[i];
      if (!is_touched[i] || block.IsPoint()) continue;
      column_[i] = size;
      blocks_.push_back(static_cast<int>(i));
      size += block.kind->TangentSize();
    }
    system_.H = Eigen::MatrixXd::Zero(size, size);
    system_.b = Eigen::VectorXd::Zero(size);
    shift_ = Eigen::VectorXd::Zero(size);
    for (const int i : blocks_) {
      const FactorGraph::Block& block = graph.blocks()[i];
      if (block.first_estimate == nullptr) continue;
      shift_.segment(column_[i], block.kind->TangentSize()) =
          block.kind->Minus(graph.values(i), block.first_estimate);
    }
  }

  // Adds factors and eliminates the points they tie, all of which leave.
  void Add(const FactorList& factors) {
    Eigen::Index rows = 0;
    std::map<int, Eigen::Index> point_column;
    for (const FactorGraph::Factor* factor : factors) {
      rows += factor->cost->num_residuals();
      for (int k = 0; k < factor->num_blocks; ++k) {
        const int i = graph_.BlocksOf(*factor)[k];
        if (graph_.blocks()[i].IsPoint()) point_column[i] = 0;
      }
    }
    const Eigen::Index size = system_.b.size();
    Eigen::Index columns = size;
    std::vector<int> eliminated;
    for (auto& [block, column] : point_column) {
      column = columns;
      columns += graph_.blocks()[block].kind->TangentSize();
    }
    for (Eigen::Index i = size; i < columns; ++i) eliminated.push_back(static_cast<int>(i));

    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, columns);
    Eigen::VectorXd r(rows);
    Eigen::Index row = 0;
    for (const FactorGraph::Factor* factor : factors) {
      const LinearizedFactor linearized = LinearizeFactor(graph_, *factor);
      const double root = std::sqrt(linearized.value.weight);
      const Eigen::Index height = linearized.value.residuals.size();
      r.segment(row, height) = root * linearized.value.residuals;
      for (int k = 0; k < factor->num_blocks; ++k) {
        const int i = graph_.BlocksOf(*factor)[k];
        const auto point = point_column.find(i);
        const Eigen::Index column = point != point_column.end() ? point->second : column_[i];
        J.block(row, column, height, linearized.jacobians[k].cols()) +=
            root * linearized.jacobians[k];
      }
      row += height;
    }
    // Residuals as they would be with every block at its linearisation point.
    r -= J.leftCols(size) * shift_;
    const SquareRootMarginalization reduced = MarginalizeSquareRoot(J, r, eliminated);
    if (reduced.J.rows() == 0) return;  // it spoke of the point alone
    system_.H.selfadjointView<Eigen::Lower>().rankUpdate(reduced.J.transpose());
    system_.b += reduced.J.transpose() * reduced.r;
  }

  // The prior over all blocks but the leaving ones.
  BlockMarginalization Finish(const std::vector<bool>& is_leaving) const {
    BlockMarginalization result;
    std::vector<int> leaving_columns;
    for (const int i : blocks_) {
      const FactorGraph::Block& block = graph_.blocks()[i];
      if (is_leaving[i]) {
        for (int k = 0; k < block.kind->TangentSize(); ++k) {
          leaving_columns.push_back(column_[i] + k);
        }
        continue;
      }
      const double* at = block.first_estimate ? block.first_estimate : graph_.values(i);
      result.prior_blocks.push_back(i);
      result.prior.blocks.push_back(
          {block.kind, block.owner, Eigen::Map<const Eigen::VectorXd>(at, block.kind->size)});
    }
    const SquareRootSystem root = SquareRoot(Marginalize(system_, leaving_columns).system);
    result.prior.A = root.A;
    result.prior.b = root.r;
    result.rank = root.rank;
    return result;
  }

 private:
  const FactorGraph& graph_;
  std::vector<int> column_;  // of each block in the system; -1: not in it
  std::vector<int> blocks_;  // in the system
  LinearSystem system_;      // lower triangle of H only
  Eigen::VectorXd shift_;    // values [-] first estimates, 0 for blocks without one
};

}  // namespace

BlockMarginalization MarginalizeBlocks(const FactorGraph& graph, const std::vector<int>& leaving) {
  std::vector<bool> is_leaving(graph.blocks().size(), false);
  for (const int block : leaving) is_leaving[block] = true;
  const FactorList selected = SelectFactors(graph, is_leaving);

  PointGroups groups(graph.blocks().size());
  const auto first_point = [&](const FactorGraph::Factor& factor) {
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int block = graph.BlocksOf(factor)[k];
      if (graph.blocks()[block].IsPoint()) return block;
    }
    return -1;
  };
  for (const FactorGraph::Factor* factor : selected) {
    for (int k = 0; k < factor->num_blocks; ++k) {
      const int block = graph.BlocksOf(*factor)[k];
      if (graph.blocks()[block].IsPoint()) groups.Join(first_point(*factor), block);
    }
  }
  std::map<int, FactorList> by_group;
  FactorList without_points;
  for (const FactorGraph::Factor* factor : selected) {
    const int point = first_point(*factor);
    (point < 0 ? without_points : by_group[groups.Find(point)]).push_back(factor);
  }

  PriorBuilder builder(graph, selected);
  if (!without_points.empty()) builder.Add(without_points);
  for (const auto& [group, factors] : by_group) builder.Add(factors);
  BlockMarginalization result = builder.Finish(is_leaving);
  result.factors = static_cast<int>(selected.size());
  return result;
}

}  // namespace prism
