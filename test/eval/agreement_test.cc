// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// Agreement with a second implementation that shares nothing with the first: rotation by Horn's
// quaternion method (Closed-form solution of absolute orientation using unit quaternions, 1987)
// instead of Umeyama's singular values, poses as 4 x 4 matrices, pairs found by trying all.
// Conventions are those of `evo`: ATE is the RMSE of the distances after alignment of the estimate
// to the reference, RPE that of the norm and angle of (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) over all pairs.
#include <cmath>
#include <filesystem>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "prism/eval/metrics.h"
#include "prism/io/trajectory_file.h"
#include "test/eval/test_trajectory.h"

namespace prism {
namespace {

struct MatrixPair {
  Eigen::Matrix4d Q;  // ground truth
  Eigen::Matrix4d P;  // estimate
};

Eigen::Matrix4d ToMatrix(const SE3& transform) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = transform.RotationMatrix();
  matrix.topRightCorner<3, 1>() = transform.translation();
  return matrix;
}

std::vector<MatrixPair> PairsByTrial(const Trajectory& truth,
                                     const Trajectory& estimate,
                                     double max_difference_s) {
  std::vector<MatrixPair> pairs;
  for (const StampedPose& p : estimate) {
    for (const StampedPose& q : truth) {
      const double difference_s = 1e-9 * std::abs(static_cast<double>(p.time_ns - q.time_ns));
      if (difference_s > max_difference_s) continue;
      pairs.push_back({ToMatrix(q.world_from_cam), ToMatrix(p.world_from_cam)});
    }
  }
  return pairs;
}

struct HornResult {
  double scale = 1;
  double rmse = 0;
};

// Where a scale is asked for it is s = sum y.Rx / sum x.x, which minimises |y - s R x|.
HornResult AlignByHorn(const std::vector<MatrixPair>& pairs, bool with_scale) {
  Eigen::Vector3d mean_x = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_y = Eigen::Vector3d::Zero();
  for (const MatrixPair& pair : pairs) {
    mean_x += pair.P.topRightCorner<3, 1>() / static_cast<double>(pairs.size());
    mean_y += pair.Q.topRightCorner<3, 1>() / static_cast<double>(pairs.size());
  }
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();  // sum of x y^T
  double sum_xx = 0;
  for (const MatrixPair& pair : pairs) {
    const Eigen::Vector3d x = pair.P.topRightCorner<3, 1>() - mean_x;
    S += x * (pair.Q.topRightCorner<3, 1>() - mean_y).transpose();
    sum_xx += x.squaredNorm();
  }
  Eigen::Matrix4d N;  // Horn's Section 4.A; its largest eigenvector is the rotation
  N(0, 0) = S.trace();
  const Eigen::Vector3d d(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  N.topRightCorner<1, 3>() = d.transpose();
  N.bottomLeftCorner<3, 1>() = d;
  N.bottomRightCorner<3, 3>() = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(N);
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  const Eigen::Matrix3d R = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix();

  HornResult result;
  if (with_scale) result.scale = (R * S).trace() / sum_xx;
  double sum = 0;
  for (const MatrixPair& pair : pairs) {
    const Eigen::Vector3d x = pair.P.topRightCorner<3, 1>() - mean_x;
    const Eigen::Vector3d y = pair.Q.topRightCorner<3, 1>() - mean_y;
    sum += (y - result.scale * R * x).squaredNorm();
  }
  result.rmse = std::sqrt(sum / static_cast<double>(pairs.size()));
  return result;
}

// RMSE over all pairs of poses that are delta apart: translation in m, rotation in degrees.
std::pair<double, double> RelativeByMatrices(const std::vector<MatrixPair>& pairs, size_t delta) {
  double sum_m = 0;
  double sum_deg = 0;
  const size_t count = pairs.size() - delta;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Matrix4d truth = pairs[i].Q.inverse() * pairs[i + delta].Q;
    const Eigen::Matrix4d E = truth.inverse() * (pairs[i].P.inverse() * pairs[i + delta].P);
    const Eigen::Matrix3d R = E.topLeftCorner<3, 3>();
    const double deg = Eigen::AngleAxisd(R).angle() * 180 / M_PI;
    sum_m += E.topRightCorner<3, 1>().squaredNorm();
    sum_deg += deg * deg;
  }
  return {std::sqrt(sum_m / static_cast<double>(count)),
          std::sqrt(sum_deg / static_cast<double>(count))};
}

// `rate_hz`: of both trajectories, which have no pose missing.
void ExpectAgreement(const Trajectory& truth, const Trajectory& estimate, int rate_hz) {
  const std::vector<MatrixPair> pairs = PairsByTrial(truth, estimate, 0.4 / rate_hz);
  const TrajectoryMetrics metrics = EvaluateTrajectory(truth, estimate);
  ASSERT_EQ(metrics.status, EvaluationStatus::kDone);
  ASSERT_EQ(metrics.matched_count, static_cast<int>(pairs.size()));
  EXPECT_NEAR(metrics.ate_rmse_m, AlignByHorn(pairs, false).rmse, 1e-6);
  EXPECT_NEAR(metrics.sim3->ate_rmse_m, AlignByHorn(pairs, true).rmse, 1e-6);
  EXPECT_NEAR(metrics.sim3->scale, AlignByHorn(pairs, true).scale, 1e-6);
  const auto [trans_m, rot_deg] = RelativeByMatrices(pairs, static_cast<size_t>(rate_hz));
  ASSERT_TRUE(metrics.relative_over_time.has_value());
  EXPECT_NEAR(metrics.relative_over_time->trans_rmse_m, trans_m, 1e-6);
  EXPECT_NEAR(metrics.relative_over_time->rot_rmse_deg, rot_deg, 1e-6);
}

TEST(Agreement, WithHornsMethodOnANoisyCurve) {
  const Trajectory truth = CurvedTrajectory(200);
  Sim3 world;
  world.scale = 1.07;
  world.rigid = SE3(Eigen::Quaterniond(0.3, 0.8, -0.2, 0.4), {1, 2, 3});
  Trajectory estimate = InWorldOf(truth, world);
  std::mt19937 generator(42);
  std::normal_distribution<double> noise(0, 0.02);
  for (StampedPose& pose : estimate) {
    Vector6d tangent;
    for (int i = 0; i < 6; ++i) tangent(i) = noise(generator);
    pose.world_from_cam = pose.world_from_cam * SE3::Exp(tangent);
  }
  ExpectAgreement(truth, estimate, 20);
}

TEST(Agreement, WithHornsMethodOnRealTrajectories) {
  const std::filesystem::path folder =
      std::filesystem::path(PRISM_SOURCE_DIR) / "../shared/data/redkitchen";
  if (!std::filesystem::exists(folder / "groundtruth.txt")) {
    GTEST_SKIP() << "needs " << folder << " (see sequences/README.md)";
  }
  ExpectAgreement(ReadTrajectory((folder / "groundtruth_reference.txt").string()),
                  ReadTrajectory((folder / "groundtruth.txt").string()),
                  30);
}

}  // namespace
}  // namespace prism
