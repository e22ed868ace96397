// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/block.h"

namespace prism {

Eigen::VectorXd BlockKind::Minus(const double* y, const double* x) const {
  if (!manifold) {
    return Eigen::Map<const Eigen::VectorXd>(y, size) - Eigen::Map<const Eigen::VectorXd>(x, size);
  }
  Eigen::VectorXd difference(TangentSize());
  manifold->Minus(y, x, difference.data());
  return difference;
}

BlockKind::RowMajorMatrix BlockKind::PlusJacobian(const double* x) const {
  if (!manifold) return RowMajorMatrix::Identity(size, size);
  RowMajorMatrix J(size, TangentSize());
  manifold->PlusJacobian(x, J.data());
  return J;
}

BlockKind::RowMajorMatrix BlockKind::MinusJacobian(const double* x) const {
  if (!manifold) return RowMajorMatrix::Identity(size, size);
  RowMajorMatrix J(TangentSize(), size);
  manifold->MinusJacobian(x, J.data());
  return J;
}

}  // namespace prism
