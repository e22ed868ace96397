// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "prism/solver/block.h"

namespace prism {

// r = sum of J_k x_k + b.
class LinearCost : public ceres::CostFunction {
 public:
  LinearCost(int rows, const std::vector<int>& sizes, std::mt19937_64* generator) {
    std::normal_distribution<double> normal;
    set_num_residuals(rows);
    *mutable_parameter_block_sizes() = sizes;
    for (const int size : sizes) {
      J_.emplace_back(rows, size);
      for (Eigen::Index i = 0; i < J_.back().size(); ++i) J_.back().data()[i] = normal(*generator);
    }
    b_ = Eigen::VectorXd(rows);
    for (Eigen::Index i = 0; i < rows; ++i) b_(i) = normal(*generator);
  }
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Eigen::VectorXd r = b_;
    for (size_t k = 0; k < J_.size(); ++k) {
      r += J_[k] * Eigen::Map<const Eigen::VectorXd>(parameters[k], J_[k].cols());
      if (jacobians == nullptr || jacobians[k] == nullptr) continue;
      std::copy_n(J_[k].data(), J_[k].size(), jacobians[k]);
    }
    std::copy_n(r.data(), r.size(), residuals);
    return true;
  }

  const BlockKind::RowMajorMatrix& jacobian(size_t block) const { return J_[block]; }

 private:
  std::vector<BlockKind::RowMajorMatrix> J_;
  Eigen::VectorXd b_;
};

}  // namespace prism
