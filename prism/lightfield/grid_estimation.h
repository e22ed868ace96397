// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/camera/micro_lens_grid.h"
#include "prism/image/image.h"

namespace prism {

// A micro-lens grid fitted to the brightness of micro images.
struct GridFit {
  MicroLensGrid grid;
  int lenses = 0;                 // micro images measured
  double rms_px = 0;              // of a measured centre about the grid, after robust weighting
  double max_change_px = 0;       // largest move of a centre against the start, over the image
  bool rotation_flipped = false;  // the start's residual rotation had the other sign
  double contrast = 0;  // (mean at centres - mean at the corners between three lenses) over the sum
};

// Fits pitch, rotation and offset of `start` to an image: each micro image's centroid is iterated
// within a disc of 0.45 pitch, the grid fitted to all centroids robustly. The white image gives
// some 0.01 px; a mean of raw frames, whose dark gaps show the grid too, some 0.2 px. Both signs of
// the residual rotation are tried. The start must be right to a third of the pitch at the corners.
// Nothing if there are fewer than 20 whole micro images.
std::optional<GridFit> RefineGrid(const ImageF& image, const MicroLensGrid& start);

// Finds a hexagonal grid in a white image from nothing: reciprocal lattice vectors by Fourier
// transform of the middle, then RefineGrid outwards. One lens type. Nothing if no hexagonal pattern
// with a pitch of 6 to 120 px stands out.
std::optional<GridFit> EstimateGrid(const ImageF& white);

// Mean of gray values of images of one size (8 or 16 bits, 1 or 3 channels), 0 to 255.
// Precondition: not empty.
ImageF MeanImage(const std::vector<cv::Mat>& images);

}  // namespace prism
