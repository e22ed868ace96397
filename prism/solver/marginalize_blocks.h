// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/solver/factor_graph.h"
#include "prism/solver/linear_prior.h"
#include "prism/solver/schur_complement.h"

namespace prism {

struct BlockMarginalization {
  // Over the blocks that stay and share a factor with one that leaves, in the order of the graph.
  LinearPrior prior;
  std::vector<int> prior_blocks;  // their numbers
  RankReport rank;                // of the prior
  int factors = 0;                // taken into the prior
};

// Takes blocks out of a graph: linearises the factors that tie them (with the weight of their
// loss), eliminates them, and states what is left as a prior over the others.
//
// - A factor that ties a leaving block to a point that stays is dropped: it would tie all points to
//   each other (as in DSO).
// - Linear factors are taken in whether or not they tie a leaving block: nothing is lost by it, and
//   one prior remains.
// - Jacobians of blocks that have a first estimate are evaluated there. The prior is linearised at
//   the first estimates of its blocks, or at the values of those that have none: from then on these
//   are their first estimates, which the caller has to keep.
//
// Precondition: the graph is prepared. `leaving`: numbers of blocks, ascending.
BlockMarginalization MarginalizeBlocks(const FactorGraph& graph, const std::vector<int>& leaving);

}  // namespace prism
