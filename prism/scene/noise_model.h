// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace prism {

// What photometric residuals of a pixel scatter by, intensities 0 to 255: the noise of both images
// and what the model leaves out (interpolation, depth edges, reflections). Residuals are weighted
// by DSO's gradient weight and divided by it.
struct NoiseModel {
  double image_sigma = 0;    // of one image, measured (EstimateImageNoise)
  double model_sigma = 3.5;  // beside the images' noise

  double ResidualSigma() const { return std::hypot(std::sqrt(2.0) * image_sigma, model_sigma); }
};

}  // namespace prism
