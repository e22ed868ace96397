// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/reference_points.h"

#include <cmath>

#include "prism/factors/visibility.h"

namespace prism {

std::optional<ReferencePoint> TransferPoint(const PlenopticProjection& camera,
                                            const RigidMotion& target_from_reference,
                                            const ReferencePoint& point) {
  Eigen::Vector3d x_V;
  if (!ProjectBetweenFrames(camera, point.px, point.rho, target_from_reference, &x_V)) {
    return std::nullopt;
  }
  // rho_j = rho_i / X_z with X = rho_i x_C,j, which is affine in rho_i.
  const auto X_z_at = [&](double rho) {
    const Eigen::Vector3d ray = ScaledRay(camera, point.px, rho);
    return (target_from_reference.R * ray + rho * target_from_reference.t).z();
  };
  const double X_z = X_z_at(point.rho);
  const double dX_z = X_z_at(1) - X_z_at(0);
  ReferencePoint seen = point;
  seen.px = x_V.head<2>();
  seen.rho = point.rho / X_z;
  seen.rho_sigma = std::abs((1 - seen.rho * dX_z) / X_z) * point.rho_sigma;
  return seen;
}

std::vector<ReferencePoint> MakeReferencePoints(const Window& window, const Keyframe& reference) {
  std::vector<ReferencePoint> points;
  for (const auto& host : window.keyframes) {
    const RigidMotion reference_from_host(reference.state.pose() * host->state.pose().Inverse());
    for (const auto& point : host->points) {
      if (host->id == reference.id) {
        points.push_back({point->patch.px, point->rho, point->rho_sigma, point->id});
        continue;
      }
      if (!IsObserved(window.camera, reference_from_host, *point, reference)) continue;
      const std::optional<ReferencePoint> seen =
          TransferPoint(window.camera,
                        reference_from_host,
                        {point->patch.px, point->rho, point->rho_sigma, point->id});
      if (seen) points.push_back(*seen);
    }
  }
  return points;
}

}  // namespace prism
