// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/depth_agreement.h"

#include <algorithm>
#include <cmath>

namespace prism {

double DepthAgreement(const Window& window,
                      const LightFieldFrame& frame,
                      const SE3& cam_from_world) {
  constexpr int kMinMeasured = 30;
  constexpr double kMinSigma = 0.004;
  int measured = 0, agreeing = 0;
  for (const auto& host : window.keyframes) {
    const RigidMotion cam_from_host(cam_from_world * host->state.pose().Inverse());
    for (const auto& point : host->points) {
      Eigen::Vector3d x_V;
      if (!ProjectBetweenFrames(window.camera, point->patch.px, point->rho, cam_from_host, &x_V) ||
          !frame.sigma.view().Contains(x_V.x(), x_V.y(), 1)) {
        continue;
      }
      const int x = static_cast<int>(x_V.x() + 0.5);
      const int y = static_cast<int>(x_V.y() + 0.5);
      const double sigma = frame.sigma(x, y);
      if (sigma == 0) continue;
      ++measured;
      agreeing += std::abs(frame.inverse_virtual_depth(x, y) - 1 / x_V.z()) <
                  3 * std::max(sigma, kMinSigma);
    }
  }
  return measured < kMinMeasured ? 0 : static_cast<double>(agreeing) / measured;
}

}  // namespace prism
