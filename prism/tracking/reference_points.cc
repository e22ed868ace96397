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
        points.push_back({point->patch.px, point->rho, point->rho_sigma});
        continue;
      }
      Eigen::Vector3d x_V;
      if (IsObserved(window.camera, reference_from_host, *point, reference) &&
          ProjectBetweenFrames(
              window.camera, point->patch.px, point->rho, reference_from_host, &x_V)) {
        // rho_j = rho_i / X_z with X = rho_i x_C,j, so drho_j / drho_i = (1 - rho_j dX_z / drho_i)
        // / X_z.
        const Eigen::Vector3d ray = ScaledRay(window.camera, point->patch.px, point->rho);
        const double X_z = (reference_from_host.R * ray + point->rho * reference_from_host.t).z();
        const Eigen::Vector3d at_infinity = ScaledRay(window.camera, point->patch.px, 0);
        const double dX_z =
            (reference_from_host.t -
             window.camera.f *
                 (reference_from_host.R * Eigen::Vector3d(at_infinity.x(), at_infinity.y(), 0)))
                .z();
        const double rho = point->rho / X_z;
        points.push_back({x_V.head<2>(), rho, std::abs((1 - rho * dX_z) / X_z) * point->rho_sigma});
      }
    }
  }
  return points;
}

}  // namespace prism
