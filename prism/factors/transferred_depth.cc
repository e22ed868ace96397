// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/transferred_depth.h"

namespace prism {

std::optional<TransferredDepth> TransferDepth(const PlenopticProjection& camera,
                                              const RigidMotion& target_from_host,
                                              const Eigen::Vector2d& host_px,
                                              double w_target) {
  // z_target = along / rho_host + shift
  const Eigen::Vector3d ray = ScaledRay(camera, host_px, 0);
  const double along = target_from_host.R.row(2).dot(ray);
  const double shift =
      target_from_host.R.row(2).dot(ScaledRay(camera, host_px, 1) - ray) + target_from_host.t.z();
  double drho_dw, dw_drho;
  const double rho_target = InverseDepth(camera, w_target, &drho_dw);
  const double before = 1 - shift * rho_target;  // along / rho_host, times rho_target
  if (!(along > 0 && before > 0)) return std::nullopt;
  const double rho_host = along * rho_target / before;
  if (!(rho_host * camera.f < 1)) return std::nullopt;
  TransferredDepth result;
  result.w = InverseVirtualDepth(camera, rho_host, &dw_drho);
  result.gain = dw_drho * along / (before * before) * drho_dw;
  return result;
}

}  // namespace prism
