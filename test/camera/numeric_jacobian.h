// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace prism {

// Central differences of f: R^n -> R^m with Richardson extrapolation (error of order h^4).
template <typename Function>
Eigen::MatrixXd NumericJacobian(const Function& f, const Eigen::VectorXd& x, double h = 1e-4) {
  const auto difference = [&](int column, double step) -> Eigen::VectorXd {
    Eigen::VectorXd plus = x, minus = x;
    plus(column) += step;
    minus(column) -= step;
    return (f(plus) - f(minus)) / (2 * step);
  };
  const Eigen::VectorXd value = f(x);
  Eigen::MatrixXd J(value.size(), x.size());
  for (int column = 0; column < x.size(); ++column) {
    J.col(column) = (4 * difference(column, h / 2) - difference(column, h)) / 3;
  }
  return J;
}

}  // namespace prism
