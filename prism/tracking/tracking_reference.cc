// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/tracking_reference.h"

#include <cmath>
#include <utility>

#include "prism/image/interpolation.h"
#include "prism/image/patch.h"

namespace prism {

TrackingReference MakeTrackingReference(const PlenopticCamera& camera,
                                        const ImagePyramid& image,
                                        const std::vector<ReferencePoint>& points) {
  TrackingReference reference;
  reference.points = points;
  constexpr double c2 = kGradientConstant * kGradientConstant;
  for (size_t level = 0; level < image.size(); ++level) {
    const PlenopticProjection projection(camera, static_cast<int>(level));
    TrackingReference::Level samples;
    samples.pixels_per_point = level == 0 ? kPatternSize : 1;
    samples.pixels = ReferencePixels(points.size() * samples.pixels_per_point);
    const double scale = std::ldexp(1.0, -static_cast<int>(level));
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d center = (points[i].px.array() + 0.5) * scale - 0.5;
      // A pattern this small is taken to have one depth.
      for (int k = 0; k < kPatternSize; ++k) {
        if (level > 0 && k != kPatternCenter) continue;
        const Eigen::Vector2d px = center + Eigen::Vector2d(kPattern[k][0], kPattern[k][1]);
        if (!image[level].view().Contains(px.x(), px.y(), 1)) continue;
        const InterpolatedValue value = InterpolateBilinear(image[level], px.x(), px.y());
        const Eigen::Vector2d m = (px - projection.c) * (projection.s / projection.f);
        const double gradient2 = value.dx * value.dx + value.dy * value.dy;
        samples.pixels.Set(level == 0 ? i * kPatternSize + k : i,
                           {m, value.value, c2 / (c2 + gradient2)});
        ++samples.count;
      }
    }
    reference.cameras.push_back(projection);
    reference.levels.push_back(std::move(samples));
  }
  return reference;
}

}  // namespace prism
