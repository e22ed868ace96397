// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/frame_pair.h"

#include <cmath>

namespace prism {

void FramePair::Update(const FrameState& host,
                       const FrameState& target,
                       const FrameState* host_first_estimate,
                       const FrameState* target_first_estimate) {
  const auto point_at = [](const FrameState& i, const FrameState& j, SE3* target_from_host) {
    *target_from_host = j.pose() * i.pose().Inverse();
    return Point{*target_from_host, std::exp(j.a() - i.a()), i.b()};
  };
  SE3 target_from_host;
  current = linearization = point_at(host, target, &target_from_host);
  first_estimate = host_first_estimate != nullptr || target_first_estimate != nullptr;
  if (first_estimate) {
    linearization = point_at(host_first_estimate ? *host_first_estimate : host,
                             target_first_estimate ? *target_first_estimate : target,
                             &target_from_host);
  }
  adjoint = target_from_host.Adjoint();
  lift_host = MinusJacobian(host.pose());
  lift_target = MinusJacobian(target.pose());
  target_b = target.b();
}

FramePair MakeFramePair(const NoiseModel& noise, const FrameState& host, const FrameState& target) {
  FramePair pair;
  pair.inverse_sigma = 1 / noise.ResidualSigma();
  pair.Update(host, target);
  return pair;
}

}  // namespace prism
