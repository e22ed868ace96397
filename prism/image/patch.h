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
inline constexpr int kPatternCenter = 4;  // index of {0, 0}
inline constexpr int kPatternRadius = 2;  // px

// True if a pixel is white where something brighter than white is expected: it says nothing of by
// how much. Intensities 0 to 255.
inline constexpr double kWhite = 254;      // and above
inline constexpr double kBrightest = 255;  // that can be seen
inline bool IsClipped(double intensity, double expected) {
  return intensity >= kWhite && expected > kBrightest;
}

// The pattern around one pixel of its host frame.
struct PhotometricPatch {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // centre, focused px
  std::array<float, kPatternSize> intensity{};   // I_i, 0 to 255
  std::array<float, kPatternSize> weight{};      // of each residual, 0 to 1, see MakePatch
};

// Samples the host image and the weights c / sqrt(c^2 + |gradient|^2) of DSO with c =
// `gradient_constant` (0 to 255 a px). False if the pattern does not fit into the image with one
// pixel to spare.
inline constexpr double kGradientConstant = 50;
bool MakePatch(const ImageViewF& host_image,
               const Eigen::Vector2d& px,
               PhotometricPatch* patch,
               double gradient_constant = kGradientConstant);

}  // namespace prism
