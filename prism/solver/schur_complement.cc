// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/schur_complement.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace prism {
namespace {

// Indices of 0 .. size - 1 that are not in `removed`, ascending.
std::vector<int> Complement(const std::vector<int>& removed, int size) {
  std::vector<bool> is_removed(size, false);
  for (const int index : removed) {
    CHECK(index >= 0 && index < size) << "variable " << index << " of " << size;
    CHECK(!is_removed[index]) << "variable " << index << " twice";
    is_removed[index] = true;
  }
  std::vector<int> kept;
  for (int i = 0; i < size; ++i) {
    if (!is_removed[i]) kept.push_back(i);
  }
  return kept;
}

// Scale factors that bring the diagonal to 1 (0 stays 0).
Eigen::VectorXd DiagonalScale(const Eigen::VectorXd& diagonal) {
  return diagonal.unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 0.0; });
}

struct ScaledEigen {
  Eigen::VectorXd scale;
  Eigen::MatrixXd vectors;  // of the eigenvalues kept
  Eigen::VectorXd values;   // kept, ascending
  RankReport report;
};

ScaledEigen DecomposeScaled(const Eigen::MatrixXd& H, double relative_tolerance) {
  ScaledEigen result;
  result.report.size = static_cast<int>(H.rows());
  result.scale = DiagonalScale(H.diagonal());
  // Only the lower triangle of H is read, here and in the solver.
  Eigen::MatrixXd scaled = H;
  for (Eigen::Index column = 0; column < H.cols(); ++column) {
    for (Eigen::Index row = column; row < H.rows(); ++row) {
      scaled(row, column) *= result.scale(row) * result.scale(column);
    }
  }
  if (H.rows() == 0) {
    result.vectors = Eigen::MatrixXd(0, 0);
    return result;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const double largest = values.size() > 0 ? values(values.size() - 1) : 0;
  Eigen::Index first = 0;
  while (first < values.size() && !(values(first) > relative_tolerance * largest)) ++first;
  const Eigen::Index kept = values.size() - first;
  result.values = values.tail(kept);
  result.vectors = solver.eigenvectors().rightCols(kept);
  result.report.rank = static_cast<int>(kept);
  result.report.condition = kept > 0 ? largest / result.values(0) : 1;
  return result;
}

}  // namespace

MarginalizationResult Marginalize(const LinearSystem& system,
                                  const std::vector<int>& marginalized,
                                  double relative_tolerance) {
  const int size = static_cast<int>(system.b.size());
  CHECK(system.H.rows() == size && system.H.cols() == size);
  const std::vector<int> kept = Complement(marginalized, size);
  const auto element = [&](int i, int j) { return i >= j ? system.H(i, j) : system.H(j, i); };

  const auto num_m = static_cast<Eigen::Index>(marginalized.size());
  const auto num_k = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd H_mm(num_m, num_m), H_km(num_k, num_m), H_kk(num_k, num_k);
  Eigen::VectorXd b_m(num_m), b_k(num_k);
  for (Eigen::Index j = 0; j < num_m; ++j) {
    b_m(j) = system.b(marginalized[j]);
    for (Eigen::Index i = 0; i < num_m; ++i) H_mm(i, j) = element(marginalized[i], marginalized[j]);
    for (Eigen::Index i = 0; i < num_k; ++i) H_km(i, j) = element(kept[i], marginalized[j]);
  }
  for (Eigen::Index j = 0; j < num_k; ++j) {
    b_k(j) = system.b(kept[j]);
    for (Eigen::Index i = 0; i < num_k; ++i) H_kk(i, j) = element(kept[i], kept[j]);
  }

  const ScaledEigen eigen = DecomposeScaled(H_mm, relative_tolerance);
  // H_mm^+ = W W^T with W = S V diag(1 / sqrt(lambda)).
  const Eigen::MatrixXd W = eigen.scale.asDiagonal() * eigen.vectors *
                            eigen.values.cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd H_kW = H_km * W;
  MarginalizationResult result;
  result.system.H = H_kk - H_kW * H_kW.transpose();
  result.system.b = b_k - H_kW * (W.transpose() * b_m);
  result.marginalized = eigen.report;
  return result;
}

SquareRootSystem SquareRoot(const LinearSystem& system, double relative_tolerance) {
  const ScaledEigen eigen = DecomposeScaled(system.H, relative_tolerance);
  const Eigen::VectorXd root = eigen.values.cwiseSqrt();
  // H = S^-1 V diag(lambda) V^T S^-1; variables without information have S = 0 and no column.
  const Eigen::VectorXd inverse_scale =
      eigen.scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  SquareRootSystem result;
  result.A = root.asDiagonal() * eigen.vectors.transpose() * inverse_scale.asDiagonal();
  result.r = root.cwiseInverse().asDiagonal() * eigen.vectors.transpose() *
             eigen.scale.asDiagonal() * system.b;
  result.rank = eigen.report;
  return result;
}

SquareRootMarginalization MarginalizeSquareRoot(const Eigen::MatrixXd& J,
                                                const Eigen::VectorXd& r,
                                                const std::vector<int>& marginalized,
                                                double relative_tolerance) {
  CHECK_EQ(J.rows(), r.size());
  if (marginalized.empty()) return {J, r, {}};
  const std::vector<int> kept = Complement(marginalized, static_cast<int>(J.cols()));
  const auto num_m = static_cast<Eigen::Index>(marginalized.size());
  const auto num_k = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd J_m(J.rows(), num_m);
  Eigen::MatrixXd rest(J.rows(), num_k + 1);  // kept columns and residuals
  for (Eigen::Index i = 0; i < num_m; ++i) {
    // Columns scaled to unit norm: the rank decision then does not depend on units.
    const double norm = J.col(marginalized[i]).norm();
    J_m.col(i) = J.col(marginalized[i]) * (norm > 0 ? 1 / norm : 0);
  }
  for (Eigen::Index i = 0; i < num_k; ++i) rest.col(i) = J.col(kept[i]);
  rest.col(num_k) = r;

  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J_m.rows(), num_m);
  qr.setThreshold(std::sqrt(relative_tolerance));
  qr.compute(J_m);
  const Eigen::Index rank = qr.rank();
  rest.applyOnTheLeft(qr.householderQ().adjoint());

  SquareRootMarginalization result;
  result.J = rest.bottomRows(J.rows() - rank).leftCols(num_k);
  result.r = rest.bottomRows(J.rows() - rank).col(num_k);
  result.marginalized.size = static_cast<int>(num_m);
  result.marginalized.rank = static_cast<int>(rank);
  if (rank > 0) {
    const Eigen::VectorXd diagonal = qr.matrixR().diagonal().head(rank).cwiseAbs();
    const double ratio = diagonal.maxCoeff() / diagonal.minCoeff();
    result.marginalized.condition = ratio * ratio;
  }
  return result;
}

}  // namespace prism
