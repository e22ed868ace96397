// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "prism/solver/factor_graph.h"

namespace prism {

// Joint covariance of all blocks that are neither points nor held, over their tangent spaces, with
// the points eliminated (Schur complement).
struct BlockCovariance {
  Eigen::MatrixXd matrix;
  std::vector<Eigen::Index> column;  // of each block of the graph in it; -1: it is not in it
};

// The inverse of the Gauss-Newton information at the values of the graph, factors taken with the
// weights of their losses. Points are blocks of size 1; a factor that ties two points or more is
// left out (it would tie all points to each other). Nothing if some block is not determined.
// Precondition: the graph is prepared.
std::optional<BlockCovariance> EvaluateBlockCovariance(const FactorGraph& graph);

}  // namespace prism
