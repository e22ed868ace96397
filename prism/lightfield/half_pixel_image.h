// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// An image smoothed and sampled at every half pixel: phase[j][i](x, y) is its value at
// (x + i / 2, y + j / 2). Bilinear interpolation between neighbours half a pixel apart keeps nearly
// the same sharpness at all positions. Between neighbours a pixel apart it would lose contrast in
// the middle between them: two images of a texture of 4 px then match best where both lie alike on
// the pixels, at a displacement of whole pixels instead of the true one.
struct HalfPixelImage {
  static constexpr int kStepsPerPixel = 2;
  ImageF phase[kStepsPerPixel][kStepsPerPixel];

  void Resize(int width, int height);

  // The four neighbours of a position and where between them it lies, in half pixels, [0, 1).
  struct Cell {
    const float* corner[4];  // (0, 0), (1, 0), (0, 1), (1, 1); pixels follow each other
    float fx, fy;
  };
  // Precondition: x and y are at least 0 and a pixel inside the right and lower edges.
  Cell At(float x, float y) const;
  // The value at the half pixel nearest to such a position; the values a pixel to the right follow.
  const float* Nearest(float x, float y) const {
    const int column = static_cast<int>(kStepsPerPixel * x + 0.5f);
    const int row = static_cast<int>(kStepsPerPixel * y + 0.5f);
    return phase[row % kStepsPerPixel][column % kStepsPerPixel].row(row / kStepsPerPixel) +
           column / kStepsPerPixel;
  }
};

// The filters (1 2 1) / 4 at whole and (1 7 7 1) / 16 at half pixels, in x and in y, which have the
// same second moment of 1/2 px^2 and nearly the same frequency response. At the edge of the image
// the nearest pixels are repeated.
void FilterHalfPixels(const ImageF& image, HalfPixelImage* filtered);

}  // namespace prism
