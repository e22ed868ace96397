// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/pose_graph.h"

#include <cmath>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "prism/geometry/se3_manifold.h"

namespace prism {
namespace {

// Symmetric, its smallest eigenvalues kept away from 0 relative to the largest: directions that an
// alignment does not see at all are none of a rigid motion.
Matrix6d Inverted(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information);
  const double smallest = 1e-9 * solver.eigenvalues().maxCoeff();
  return solver.eigenvectors() *
         solver.eigenvalues().cwiseMax(smallest).cwiseInverse().asDiagonal() *
         solver.eigenvectors().transpose();
}

struct PoseEdgeResidual {
  SE3 from_from_to;  // measured
  Matrix6d root;

  bool operator()(const double* from, const double* to, double* residuals) const {
    Eigen::Map<Vector6d>{residuals} = root * (SE3(to) * SE3(from).Inverse() * from_from_to).Log();
    return true;
  }
};

}  // namespace

Matrix6d EdgeInformation(const Matrix6d& alignment_information,
                         const SE3& to_from_from,
                         double median_rho) {
  // The measured scale of a keyframe's depths scatters by about this (docs/depth.md).
  constexpr double kScaleSigma = 0.005;
  const double sigma = kScaleSigma * to_from_from.translation().norm();
  Matrix6d covariance = Inverted(alignment_information);
  covariance.diagonal().head<3>().array() += sigma * sigma;
  covariance.diagonal().tail<3>().array() += std::pow(sigma * median_rho, 2);
  return Inverted(covariance);
}

void OptimizePoses(const std::vector<PoseEdge>& edges,
                   const std::vector<int>& held,
                   std::map<int, SE3>* poses) {
  constexpr double kLoopScale = 10;  // standard deviations
  ceres::Problem problem;
  for (const PoseEdge& edge : edges) {
    const auto from = poses->find(edge.from), to = poses->find(edge.to);
    if (from == poses->end() || to == poses->end()) continue;
    // Few hundred edges: numeric derivatives cost nothing that matters.
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<PoseEdgeResidual, ceres::CENTRAL, 6, 7, 7>(
            new PoseEdgeResidual{edge.to_from_from.Inverse(), edge.information.llt().matrixU()}),
        edge.is_loop ? new ceres::CauchyLoss(kLoopScale) : nullptr,
        from->second.data(),
        to->second.data());
  }
  for (auto& [id, pose] : *poses) {
    if (!problem.HasParameterBlock(pose.data())) continue;
    problem.SetManifold(pose.data(), new SE3Manifold());
  }
  for (const int id : held) {
    double* pose = poses->at(id).data();
    if (problem.HasParameterBlock(pose)) problem.SetParameterBlockConstant(pose);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

}  // namespace prism
