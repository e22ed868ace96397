// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/reference_points.h"

#include "prism/factors/visibility.h"

namespace prism {

std::vector<ReferencePoint> MakeReferencePoints(const Window& window, const Keyframe& reference) {
  std::vector<ReferencePoint> points;
  for (const auto& host : window.keyframes) {
    const RigidMotion reference_from_host(reference.state.pose() * host->state.pose().Inverse());
    for (const auto& point : host->points) {
      if (host->id == reference.id) {
        points.push_back({point->patch.px, point->rho});
        continue;
      }
      Eigen::Vector3d x_V;
      if (IsObserved(window.camera, reference_from_host, *point, reference) &&
          ProjectBetweenFrames(
              window.camera, point->patch.px, point->rho, reference_from_host, &x_V)) {
        points.push_back({x_V.head<2>(), InverseDepth(window.camera, 1 / x_V.z())});
      }
    }
  }
  return points;
}

}  // namespace prism
