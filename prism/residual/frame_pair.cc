// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/residual/frame_pair.h"

#include <cmath>

namespace prism {

void FramePair::Update(const FrameState& host,
                       const FrameState& target,
                       const FrameState* host_first_estimate,
                       const FrameState* target_first_estimate) {
  const SE3 target_from_host = target.pose() * host.pose().Inverse();
  current = {target_from_host.RotationMatrix(), target_from_host.translation()};
  first_estimate = host_first_estimate != nullptr || target_first_estimate != nullptr;
  if (first_estimate) {
    const FrameState& host_at = host_first_estimate ? *host_first_estimate : host;
    const FrameState& target_at = target_first_estimate ? *target_first_estimate : target;
    const SE3 linearized = target_at.pose() * host_at.pose().Inverse();
    linearization = {linearized.RotationMatrix(), linearized.translation()};
    adjoint = linearized.Adjoint();
  } else {
    linearization = current;
    adjoint = target_from_host.Adjoint();
  }
  lift_host = MinusJacobian(host.pose());
  lift_target = MinusJacobian(target.pose());
  gain = std::exp(target.a() - host.a());
  host_b = host.b();
  target_b = target.b();
}

}  // namespace prism
