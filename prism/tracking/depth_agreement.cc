// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/depth_agreement.h"

#include <algorithm>
#include <cmath>

namespace prism {

std::optional<double> DepthAgreement(const TrackingReference& reference,
                                     const FrameAlignmentResult& alignment,
                                     const LightFieldFrame& frame,
                                     double depth_offset) {
  constexpr int kMinMeasured = 100;  // they lie in groups that err together
  constexpr double kMinSigma = 0.004;
  const RigidMotion motion(alignment.state.target_from_reference);
  int measured = 0, agreeing = 0;
  for (size_t i = 0; i < alignment.points.fits.size(); ++i) {
    const ReferencePoint& point = reference.points[i];
    Eigen::Vector3d x_V;
    if (alignment.points.fits[i] != PointFit::kFits ||
        !ProjectBetweenFrames(reference.cameras[0], point.px, point.rho, motion, &x_V) ||
        !frame.sigma.view().Contains(x_V.x(), x_V.y(), 1)) {
      continue;
    }
    const int x = static_cast<int>(x_V.x() + 0.5);
    const int y = static_cast<int>(x_V.y() + 0.5);
    const double sigma = frame.sigma(x, y);
    if (sigma == 0) continue;
    ++measured;
    const double w = frame.inverse_virtual_depth(x, y) - depth_offset;
    agreeing += std::abs(w - 1 / x_V.z()) < 3 * std::max(sigma, kMinSigma);
  }
  if (measured < kMinMeasured) return std::nullopt;
  return static_cast<double>(agreeing) / measured;
}

Tracker::DepthCheck MakeDepthCheck(const NoiseModel& noise,
                                   const LightFieldFrame& frame,
                                   double depth_offset,
                                   double unknown) {
  return [&noise, &frame, depth_offset, unknown](const TrackingReference& reference,
                                                 const FrameAlignmentResult& alignment) {
    const std::optional<double> agreement =
        DepthAgreement(reference, alignment, frame, depth_offset);
    return agreement ? *agreement / noise.UsualDepthAgreement() : unknown;
  };
}

}  // namespace prism
