// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "prism/camera/micro_lens_grid.h"
#include "prism/image/image.h"

namespace prism {

struct MeasuredCenter {
  LensIndex lens;
  Eigen::Vector2d center;
  double weight = 1;
};

// Centroids of the brightness of micro images whose centres `grid` gives to a third of the pitch,
// each iterated within a disc of 0.45 pitch, for the lenses within `region` px of the image centre
// along either axis. What a micro image shows moves its centroid: some pixels in a raw frame.
std::vector<MeasuredCenter> MeasureCentroids(const ImageF& image,
                                             const MicroLensGrid& grid,
                                             double region);

// Centres of micro images that `grid` gives to about a tenth of the pitch, told apart from what the
// micro images show. The logarithm of a micro image is modelled as
//   log I(c + m) = a + b . m + P(m - d)
// over the cell of its lens, with P the profile all micro images share (their mean, made even: the
// centre is where the shading is symmetric) and a, b the brightness and gradient of what this one
// shows; least squares gives d, and from its residual the weight. A scene that becomes brighter
// across the lenses makes each micro image brighter across itself and so shifts its centroid, but
// not d. Lenses whose d is uncertain by more than a quarter of the pitch, or hardly to be told from
// b because the shading has no rim, are left out.
std::vector<MeasuredCenter> MeasureByProfile(const ImageF& image, const MicroLensGrid& grid);

// Indices of the lenses whose centres lie in the image and within `region` px of its centre along
// either axis.
std::vector<LensIndex> LensesWithin(const MicroLensGrid& grid,
                                    int width,
                                    int height,
                                    double region);

}  // namespace prism
