// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// Standard deviation of the noise of an image, from its second differences (J. Immerkaer, Fast
// noise variance estimation, CVIU 1996) with the median in place of the mean, so that texture and
// edges count little. Clipped black and white areas are left out. 0 for an image without other
// pixels.
double EstimateImageNoise(const ImageViewF& image);

}  // namespace prism
