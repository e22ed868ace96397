// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// Value of the bilinear interpolant at a position and its exact derivative there. The interpolant
// is not differentiable on pixel rows and columns; the derivative to the right / below is returned.
// Computed in double: positions keep their precision, and derivatives can be checked to 1e-8.
struct InterpolatedValue {
  double value;
  double dx;
  double dy;
};

// Precondition: 0 <= x <= width - 1 and 0 <= y <= height - 1 (ImageView::Contains), both sides
// >= 2.
inline InterpolatedValue InterpolateBilinear(const ImageViewF& image, double x, double y) {
  int x0 = static_cast<int>(x);
  int y0 = static_cast<int>(y);
  if (x0 > image.width - 2) x0 = image.width - 2;
  if (y0 > image.height - 2) y0 = image.height - 2;
  const double fx = x - x0;
  const double fy = y - y0;
  const float* p = image.data + y0 * image.stride + x0;
  const double v00 = p[0];
  const double v10 = p[1];
  const double v01 = p[image.stride];
  const double v11 = p[image.stride + 1];
  const double top = v00 + fx * (v10 - v00);
  const double bottom = v01 + fx * (v11 - v01);
  return {top + fy * (bottom - top), (v10 - v00) + fy * ((v11 - v01) - (v10 - v00)), bottom - top};
}

}  // namespace prism
