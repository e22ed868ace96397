// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/image/patch.h"

#include <cmath>

#include "prism/image/interpolation.h"

namespace prism {

bool MakePatch(const ImageViewF& host_image,
               const Eigen::Vector2d& px,
               PhotometricPatch* patch,
               double gradient_constant) {
  if (!host_image.Contains(px.x(), px.y(), kPatternRadius + 1)) return false;
  const auto value = [&](double x, double y) {
    return InterpolateBilinear(host_image, x, y).value;
  };
  const double c2 = gradient_constant * gradient_constant;
  patch->px = px;
  for (int k = 0; k < kPatternSize; ++k) {
    const double x = px.x() + kPattern[k][0];
    const double y = px.y() + kPattern[k][1];
    const double dx = 0.5 * (value(x + 1, y) - value(x - 1, y));
    const double dy = 0.5 * (value(x, y + 1) - value(x, y - 1));
    patch->intensity[k] = static_cast<float>(value(x, y));
    patch->weight[k] = static_cast<float>(std::sqrt(c2 / (c2 + dx * dx + dy * dy)));
  }
  return true;
}

}  // namespace prism
