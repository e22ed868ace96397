// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/linear_prior.h"

#include <utility>

#include <glog/logging.h>

namespace prism {

LinearPriorCost::LinearPriorCost(const LinearPrior* prior) : prior_(prior) {
  CHECK_EQ(prior->A.rows(), prior->b.size());
  Eigen::Index columns = 0;
  for (const LinearPrior::Block& block : prior->blocks) {
    mutable_parameter_block_sizes()->push_back(block.kind->size);
    columns += block.kind->TangentSize();
  }
  CHECK_EQ(prior->A.cols(), columns);
  set_num_residuals(static_cast<int>(prior->A.rows()));
}

bool LinearPriorCost::Evaluate(double const* const* parameters,
                               double* residuals,
                               double** jacobians) const {
  const std::vector<LinearPrior::Block>& blocks = prior_->blocks;
  Eigen::VectorXd difference(prior_->A.cols());
  Eigen::Index column = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const int size = blocks[i].kind->TangentSize();
    difference.segment(column, size) =
        blocks[i].kind->Minus(parameters[i], blocks[i].linearization.data());
    column += size;
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = prior_->A * difference + prior_->b;
  if (jacobians == nullptr) return true;

  column = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const int size = blocks[i].kind->TangentSize();
    if (jacobians[i] != nullptr) {
      Eigen::Map<BlockKind::RowMajorMatrix>(jacobians[i], num_residuals(), blocks[i].kind->size) =
          prior_->A.middleCols(column, size) * blocks[i].kind->MinusJacobian(parameters[i]);
    }
    column += size;
  }
  return true;
}

LinearPrior MakeNormalPrior(BlockKindPtr kind,
                            int owner,
                            const Eigen::VectorXd& mean,
                            const Eigen::VectorXd& sigma) {
  CHECK_EQ(mean.size(), kind->size) << kind->name;
  CHECK_EQ(sigma.size(), kind->TangentSize()) << kind->name;
  CHECK((sigma.array() > 0).all()) << kind->name << ": a standard deviation that is not positive";
  LinearPrior prior;
  prior.A = sigma.cwiseInverse().asDiagonal();
  prior.b = Eigen::VectorXd::Zero(sigma.size());
  prior.blocks = {{std::move(kind), owner, mean}};
  return prior;
}

}  // namespace prism
