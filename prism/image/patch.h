// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <Eigen/Core>

#include "prism/image/image.h"

namespace prism {

// The residual pattern of DSO (J. Engel et al., Direct Sparse Odometry, PAMI 2018, Fig. 4).
inline constexpr int kPatternSize = 8;
inline constexpr std::array<std::array<int, 2>, kPatternSize> kPattern = {
    {{0, -2}, {-1, -1}, {1, -1}, {-2, 0}, {0, 0}, {2, 0}, {-1, 1}, {0, 2}}};
inline constexpr int kPatternRadius = 2;  // px

// The pattern around one pixel of its host frame.
struct PhotometricPatch {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // centre, focused px
  std::array<float, kPatternSize> intensity{};   // I_i, 0 to 255
  std::array<float, kPatternSize> weight{};      // factor of each residual, see MakePatch
};

struct PhotometricOptions {
  double intensity_sigma = 4;     // standard deviation of a residual, 0 to 255
  double gradient_constant = 50;  // c of DSO's weight c^2 / (c^2 + |gradient|^2); 0 to 255 a px
};

// Samples the host image and its weights: sqrt(c^2 / (c^2 + |gradient|^2)) / intensity_sigma.
// False if the pattern does not fit into the image with one pixel to spare.
bool MakePatch(const ImageViewF& host_image,
               const Eigen::Vector2d& px,
               const PhotometricOptions& options,
               PhotometricPatch* patch);

}  // namespace prism
