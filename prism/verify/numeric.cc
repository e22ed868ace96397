// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/verify/numeric.h"

#include <algorithm>
#include <cmath>

namespace prism {

Eigen::MatrixXd NumericTangentJacobian(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals_at, int dimension) {
  const auto difference = [&](int column, double h) -> Eigen::VectorXd {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(dimension);
    delta(column) = h;
    return (residuals_at(delta) - residuals_at(-delta)) / (2 * h);
  };
  constexpr double kStep = 2e-6;
  const Eigen::VectorXd first = difference(0, kStep);
  Eigen::MatrixXd J(first.size(), dimension);
  for (int column = 0; column < dimension; ++column) {
    J.col(column) = (4 * difference(column, kStep / 2) - difference(column, kStep)) / 3;
  }
  return J;
}

void RaiseMixedError(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double* error) {
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double x = a.data()[i];
    const double y = b.data()[i];
    const double mixed = std::abs(x - y) / (1 + std::max(std::abs(x), std::abs(y)));
    // Written so that a NaN counts as the largest disagreement.
    if (!(mixed <= *error)) *error = std::isnan(mixed) ? INFINITY : mixed;
  }
}

}  // namespace prism
