// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/image/image.h"

namespace prism {

// Levels of half the size each; level 0 is the image itself. A pixel of level l+1 is the mean of
// 2 x 2 pixels of level l (an odd last row or column is left out), so that
// x_l = (x_{l+1} + 0.5) * 2 - 0.5.
using ImagePyramid = std::vector<ImageF>;

// Half-sized image as described above. Precondition: both sides >= 2.
ImageF HalveImage(const ImageViewF& image);

// At most `max_levels` levels, none with a side below `min_side` pixels (level 0 always present).
ImagePyramid BuildPyramid(ImageF image, int max_levels, int min_side = 30);

// |gradient|^2 by central differences; 0 on the one-pixel border.
ImageF SquaredGradientMagnitude(const ImageViewF& image);

}  // namespace prism
