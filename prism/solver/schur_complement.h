// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace prism {

// The quadratic E(x) = 1/2 x^T H x + b^T x of a linearised least-squares problem, with H = J^T J
// and b = J^T r. H is symmetric; only its lower triangle is read.
struct LinearSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
};

// How a symmetric positive semidefinite block was inverted.
struct RankReport {
  int size = 0;
  int rank = 0;          // eigenvalues above the threshold, after scaling the diagonal to 1
  double condition = 1;  // largest over smallest eigenvalue above the threshold, after scaling
};

struct MarginalizationResult {
  LinearSystem system;  // over the kept variables, in their old order
  RankReport marginalized;
};

// Schur complement: minimises E over the variables `marginalized` (indices into x, distinct, in any
// order) and returns the quadratic left over the others,
//   H' = H_kk - H_km H_mm^+ H_mk,  b' = b_k - H_km H_mm^+ b_m.
// H_mm is scaled to unit diagonal before it is inverted; directions whose eigenvalue then falls
// below `relative_tolerance` times the largest are left out (pseudo-inverse): no information about
// a variable means nothing is passed on through it.
MarginalizationResult Marginalize(const LinearSystem& system,
                                  const std::vector<int>& marginalized,
                                  double relative_tolerance = 1e-12);

// Factor A, r with H = A^T A and b = A^T r, from the eigenvectors of H scaled to unit diagonal; A
// has as many rows as H has rank. The part of b outside the range of H (numerical noise) is
// dropped.
struct SquareRootSystem {
  Eigen::MatrixXd A;  // rank x n
  Eigen::VectorXd r;  // rank
  RankReport rank;
};
SquareRootSystem SquareRoot(const LinearSystem& system, double relative_tolerance = 1e-12);

// Square-root marginalisation of one variable block from a Jacobian J (m x n) and residuals r:
// Householder QR of the marginalised columns, whose rows are dropped. What is left has the same
// Schur complement without ever squaring the condition number. Columns of the marginalised
// variables are removed from the result. Rank-deficient blocks drop only as many rows as their
// rank.
struct SquareRootMarginalization {
  Eigen::MatrixXd J;
  Eigen::VectorXd r;
  RankReport marginalized;
};
SquareRootMarginalization MarginalizeSquareRoot(const Eigen::MatrixXd& J,
                                                const Eigen::VectorXd& r,
                                                const std::vector<int>& marginalized,
                                                double relative_tolerance = 1e-12);

}  // namespace prism
