// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/block_covariance.h"

#include <cmath>

#include <glog/logging.h>
#include <Eigen/Cholesky>

#include "prism/solver/linearize.h"

namespace prism {
namespace {

// Normal equations over points (a row each) and the other blocks.
struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd points;    // diagonal of the points' part, which has nothing else
  Eigen::MatrixXd coupling;  // columns of blocks x points
};

void AddFactor(const FactorGraph& graph,
               const FactorGraph::Factor& factor,
               const std::vector<Eigen::Index>& column,
               const std::vector<Eigen::Index>& point_number,
               NormalEquations* equations) {
  const int* const blocks = graph.BlocksOf(factor);
  Eigen::Index point = -1;
  int point_at = -1;
  for (int k = 0; k < factor.num_blocks; ++k) {
    if (point_number[blocks[k]] < 0) continue;
    if (point >= 0) return;
    point = point_number[blocks[k]];
    point_at = k;
  }
  const LinearizedFactor linearized = LinearizeFactor(graph, factor);
  const double weight = linearized.value.weight;
  const std::vector<Eigen::MatrixXd>& J = linearized.jacobians;
  if (point >= 0) equations->points(point) += weight * J[point_at].squaredNorm();
  for (int i = 0; i < factor.num_blocks; ++i) {
    const Eigen::Index row = column[blocks[i]];
    if (row < 0) continue;
    if (point >= 0) {
      equations->coupling.col(point).segment(row, J[i].cols()) +=
          weight * J[i].transpose() * J[point_at];
    }
    for (int j = 0; j < factor.num_blocks; ++j) {
      if (column[blocks[j]] < 0) continue;
      equations->H.block(row, column[blocks[j]], J[i].cols(), J[j].cols()) +=
          weight * J[i].transpose() * J[j];
    }
  }
}

// Nothing if H is not positive definite.
std::optional<Eigen::MatrixXd> InverseOfPositiveDefinite(const Eigen::MatrixXd& H) {
  if (!(H.diagonal().array() > 0).all()) return std::nullopt;
  const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> factorized(scale.asDiagonal() * H * scale.asDiagonal());
  if (factorized.info() != Eigen::Success || !(factorized.vectorD().minCoeff() > 1e-13)) {
    return std::nullopt;
  }
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(H.rows(), H.cols());
  return scale.asDiagonal() * factorized.solve(identity) * scale.asDiagonal();
}

}  // namespace

std::optional<BlockCovariance> EvaluateBlockCovariance(const FactorGraph& graph) {
  BlockCovariance result;
  const size_t num_blocks = graph.blocks().size();
  result.column.assign(num_blocks, -1);
  std::vector<Eigen::Index> point_number(num_blocks, -1);
  Eigen::Index size = 0, num_points = 0;
  for (size_t i = 0; i < num_blocks; ++i) {
    const FactorGraph::Block& block = graph.blocks()[i];
    if (block.is_constant) continue;
    if (block.IsPoint()) {
      CHECK_EQ(block.kind->TangentSize(), 1);
      point_number[i] = num_points++;
    } else {
      result.column[i] = size;
      size += block.kind->TangentSize();
    }
  }
  NormalEquations equations = {Eigen::MatrixXd::Zero(size, size),
                               Eigen::VectorXd::Zero(num_points),
                               Eigen::MatrixXd::Zero(size, num_points)};
  for (const FactorGraph::Factor& factor : graph.factors()) {
    AddFactor(graph, factor, result.column, point_number, &equations);
  }
  for (Eigen::Index i = 0; i < num_points; ++i) {
    const double known = equations.points(i);
    equations.coupling.col(i) *= known > 0 ? 1 / std::sqrt(known) : 0;
  }
  equations.H.noalias() -= equations.coupling * equations.coupling.transpose();
  std::optional<Eigen::MatrixXd> covariance = InverseOfPositiveDefinite(equations.H);
  if (!covariance) return std::nullopt;
  result.matrix = std::move(*covariance);
  return result;
}

}  // namespace prism
