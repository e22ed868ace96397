// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/reference_points.h"

#include <cmath>

#include "prism/factors/visibility.h"

namespace prism {

std::vector<ReferencePoint> MakeReferencePoints(const Window& window, const Keyframe& reference) {
  std::vector<ReferencePoint> points;
  for (const auto& host : window.keyframes) {
    const RigidMotion reference_from_host(reference.state.pose() * host->state.pose().Inverse());
    for (const auto& point : host->points) {
      if (host->id == reference.id) {
        points.push_back({point->patch.px, point->rho, point->rho_sigma, point->id});
        continue;
      }
      Eigen::Vector3d x_V;
      if (IsObserved(window.camera, reference_from_host, *point, reference) &&
          ProjectBetweenFrames(
              window.camera, point->patch.px, point->rho, reference_from_host, &x_V)) {
        // rho_j = rho_i / X_z with X = rho_i x_C,j, which is affine in rho_i.
        const auto X_z_at = [&](double rho) {
          const Eigen::Vector3d ray = ScaledRay(window.camera, point->patch.px, rho);
          return (reference_from_host.R * ray + rho * reference_from_host.t).z();
        };
        const double X_z = X_z_at(point->rho);
        const double dX_z = X_z_at(1) - X_z_at(0);
        const double rho = point->rho / X_z;
        points.push_back(
            {x_V.head<2>(), rho, std::abs((1 - rho * dX_z) / X_z) * point->rho_sigma, point->id});
      }
    }
  }
  return points;
}

}  // namespace prism
