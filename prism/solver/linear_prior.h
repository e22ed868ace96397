// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "prism/solver/block.h"

namespace prism {

// What marginalised blocks still say about those that remain:
//   r = A (x [-] x_lin) + b,
// with [-] the difference of each block's manifold.
struct LinearPrior {
  struct Block {
    BlockKindPtr kind;
    int owner = kRunOwner;          // as in FactorGraph::Block
    Eigen::VectorXd linearization;  // x_lin, kind->size numbers
  };
  Eigen::MatrixXd A;  // rows x sum of tangent sizes
  Eigen::VectorXd b;  // rows
  std::vector<Block> blocks;

  bool empty() const { return A.rows() == 0; }
};

// Residuals: rows of A. Parameter blocks: those of the prior, in its order. Jacobian: A at every x
// (first estimate: the prior was linearised once), lifted to the stored doubles at the current
// value. The derivative of [-] away from x_lin, which differs from the identity by O(|x [-]
// x_lin|), is left out on purpose: taking it in would move the null space that A was built with.
// `prior` must outlive the cost.
class LinearPriorCost : public ceres::CostFunction {
 public:
  explicit LinearPriorCost(const LinearPrior* prior);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const LinearPrior* prior_;
};

// r = (x [-] mean) / sigma of one block. Residuals: the block's tangent size. The Jacobian is taken
// as the identity over sigma at every x, lifted at the current value, as above.
// Precondition: sigma > 0.
LinearPrior MakeNormalPrior(BlockKindPtr kind,
                            int owner,
                            const Eigen::VectorXd& mean,
                            const Eigen::VectorXd& sigma);

}  // namespace prism
