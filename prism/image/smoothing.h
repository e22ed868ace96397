// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// Standard deviation of white noise after the filter below over that before.
inline constexpr double kSmoothedNoise = 0.375;

// A row of the image under the filter (1 2 1) x (1 2 1) / 16; the outermost columns are copied, the
// rows above the first and below the last are taken to be like them.
void SmoothRow(const ImageViewF& image, int y, float* smooth);

// The same of a row with those above and below it.
void SmoothRow(const float* above, const float* here, const float* below, int width, float* smooth);

// All rows. Bilinear interpolation of what comes out keeps nearly the same sharpness and noise at
// all positions between pixels. Without, both are least in the middle between pixels, and fits are
// drawn to positions where that makes residuals small.
ImageF Smooth(const ImageViewF& image);

}  // namespace prism
