// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/lightfield/lens_table.h"

namespace prism {

// How micro images darken towards their rims, as the frames themselves show it.
struct Vignetting {
  // What a white image would look like: one channel, 16 bits, of the raw frames' size, 0 between
  // the micro images. The same for all lenses of a type in a part of the image.
  cv::Mat white;
  double rim = 1;        // brightness at 0.85 of the radius over that at the centre, darkest type
  int micro_images = 0;  // it was measured on, of all frames together

  // Frames whose micro images are as bright at the rim have been corrected already (or the shading
  // is too weak to matter).
  bool IsNeeded() const { return rim < 0.96; }
};

// For each lens type the mean, over its micro images with light in each of up to 3 x 3 regions that
// are blended, of the brightness at each place relative to that around the centre; between the
// quartiles, so that edges do not count. What a scene shows there differs from lens to lens and
// averages out. Nothing if one type has fewer than 100 micro images to tell from.
// `frames`: raw images, 8 or 16 bits, 1 or 3 channels.
std::optional<Vignetting> EstimateVignetting(const LensTable& lenses,
                                             const std::vector<cv::Mat>& frames);

}  // namespace prism
