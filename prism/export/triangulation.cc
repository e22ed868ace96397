// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/triangulation.h"

#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

namespace prism {
namespace {

constexpr int kIterations = 8;

// Sums over the observations; infinite errors where one does not see the point.
struct Sums {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double cost = 0;
  double error = 0;
};

Sums Evaluate(const PlenopticProjection& camera,
              const std::vector<SE3>& cam_from_world,
              const Track& track,
              const Eigen::Vector3d& p_in_world,
              double kink_px) {
  Sums sums;
  const double f = camera.FocalLengthPx();
  for (const Observation& seen : track.observations) {
    const SE3& pose = cam_from_world[seen.keyframe];
    Eigen::Vector2d px;
    if (!ProjectToKeyframe(camera, pose, p_in_world, &px)) {
      sums.cost = sums.error = std::numeric_limits<double>::infinity();
      return sums;
    }
    const Eigen::Vector3d p = pose * p_in_world;
    const double zeta = p.z() - camera.center_z();
    Eigen::Matrix<double, 2, 3> J;
    J << f / zeta, 0, -f * p.x() / (zeta * zeta), 0, f / zeta, -f * p.y() / (zeta * zeta);
    J = J * pose.RotationMatrix();
    const Eigen::Vector2d residual = seen.px - px;
    const double error = residual.norm();
    const double weight = error <= kink_px ? 1 : kink_px / error;  // Huber
    sums.H += weight * J.transpose() * J;
    sums.b += weight * J.transpose() * residual;
    sums.cost += error <= kink_px ? error * error : kink_px * (2 * error - kink_px);
    sums.error += error;
  }
  return sums;
}

}  // namespace

TriangulatedPoint Triangulate(const PlenopticProjection& camera,
                              const std::vector<SE3>& cam_from_world,
                              const Track& track,
                              const Eigen::Vector3d& start,
                              double kink_px) {
  Eigen::Vector3d p = start;
  Sums sums = Evaluate(camera, cam_from_world, track, p, kink_px);
  for (int i = 0; i < kIterations; ++i) {
    // Along rays that are nearly parallel nothing is known, and nothing moves.
    const Eigen::Matrix3d H = sums.H + 1e-6 * sums.H.trace() * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d next = p + H.ldlt().solve(sums.b);
    const Sums next_sums = Evaluate(camera, cam_from_world, track, next, kink_px);
    if (!(next_sums.cost < sums.cost)) break;
    p = next;
    sums = next_sums;
  }
  return {p, sums.error / static_cast<double>(track.observations.size())};
}

TriangulatedPoint TriangulateWithoutOutliers(const PlenopticProjection& camera,
                                             const std::vector<SE3>& cam_from_world,
                                             const Eigen::Vector3d& start,
                                             Track* track,
                                             double max_error_px) {
  TriangulatedPoint point = Triangulate(camera, cam_from_world, *track, start);
  const auto is_outlier = [&](const Observation& seen) {
    Eigen::Vector2d px;
    return !ProjectToKeyframe(camera, cam_from_world[seen.keyframe], point.p_in_world, &px) ||
           (seen.px - px).norm() > max_error_px;
  };
  auto& observations = track->observations;
  const auto end = std::remove_if(observations.begin(), observations.end(), is_outlier);
  if (end == observations.end()) return point;
  observations.erase(end, observations.end());
  if (observations.size() < 2) return point;
  return Triangulate(camera, cam_from_world, *track, point.p_in_world);
}

}  // namespace prism
