// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/camera/projection.h"
#include "prism/image/image.h"

namespace prism {

// What is done for every pixel of an RGB-D frame, a row of the focused grid at a time.
//
// Rows given and returned have room for kRgbdRowPadding values more than the image is wide, which
// are read and written but mean nothing.
inline constexpr int kRgbdRowPadding = 16;
// By so many pixels an image goes on beyond its sides for ResampleRow.
inline constexpr int kRgbdBorder = 4;

// Positions in the pinhole image that the pixels of row y show: Eq. (88) holds with the depth found
// there, solved by fixed-point iteration (the magnification changes by some per cent only, so that
// three steps reach rounding on a smooth surface). `filled` is 1/z of the pinhole image, without
// holes.
void FindPinholePositions(
    const PlenopticProjection& camera, const ImageViewF& filled, int y, float* px, float* py);

// Inverse virtual depth at these positions plus sigma times `noise`; 0 where there is none, or it
// is not in (0, 0.5]. The inverse depth 1/z (0: hole) is interpolated on a smooth surface, the
// nearest pixel's where neighbours differ by more than `edge_ratio` of the larger or one is a hole,
// and none where the nearest is one.
void MeasureInverseVirtualDepth(const PlenopticProjection& camera,
                                const ImageViewF& inverse_depth,
                                float edge_ratio,
                                const float* px,
                                const float* py,
                                const float* noise,
                                float sigma,
                                float* inverse_virtual_depth);

// The image at these positions, bicubic as OpenCV's (a = -0.75, positions to 1/32 px). `image` has
// a border of kRgbdBorder pixels that repeat its sides; positions farther out are taken to it.
void ResampleRow(const ImageViewF& image, const float* px, const float* py, float* values);

}  // namespace prism
