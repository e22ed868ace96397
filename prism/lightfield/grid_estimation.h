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
  bool rotation_flipped = false;  // nearer to the opposite of the start's residual rotation
  double contrast = 0;  // (mean at centres - mean at the corners between three lenses) over the sum
};

// Fits pitch, rotation and offset of `start` to a white image, robustly to the centroids of all
// micro images; some 0.01 px. Both signs of the residual rotation are tried. The start must be
// right to a third of the pitch at the corners. Nothing if there are fewer than 20 whole micro
// images.
std::optional<GridFit> RefineGrid(const ImageF& white, const MicroLensGrid& start);

// The same for a mean of raw frames. What the scene shows moves centroids; where the micro images
// have rims or dark gaps between them, their shifts against their common profile replace them
// (micro_image_centers.h): some 0.01 px again.
std::optional<GridFit> RefineGridOnFrames(const ImageF& mean_frame, const MicroLensGrid& start);

// Finds a hexagonal or square grid in a white image from nothing: reciprocal lattice vectors by
// Fourier transform of the middle, then as RefineGrid outwards. One lens type. Nothing if there is
// no pattern with a pitch of 6 to 120 px that fits to 5 % of its pitch (RMS) and is brighter at
// the centres than between them.
std::optional<GridFit> EstimateGrid(const ImageF& white);

// The same in a mean of raw frames, as RefineGridOnFrames.
std::optional<GridFit> EstimateGridOnFrames(const ImageF& mean_frame);

// Mean of gray values of images of one size (8 or 16 bits, 1 or 3 channels), 0 to 255.
// Precondition: not empty.
ImageF MeanImage(const std::vector<cv::Mat>& images);

}  // namespace prism
