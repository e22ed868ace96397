// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "prism/factors/pixel_residuals.h"

namespace prism {

// Sums of frame alignment over many pixels and points (LevelAlignment). All arrays are filled up to
// whole batches of kPixelBatch numbers.

// Of robust squares, over pixels or depths. Huber's norm: m (2 |r| - m) with m = min(|r|, huber).
struct RobustSum {
  double energy = 0;
  double visible = 0, inliers = 0;  // pixels
};

// Weights of a batch's residuals in the normal equations: Huber's times the pixel's own, 0 for what
// is not seen or beyond `outlier`, which costs the same wherever it is. `weights` may be null.
void WeighPixels(const PixelResiduals& residuals,
                 const double* pixel_weight,
                 double huber,
                 double outlier,
                 double* weights,
                 RobustSum* sum);

// The normal equations of points' inverse depths, point by point: columns of `stride` numbers.
inline constexpr int kNumColumns = 9;  // coupling to [pose; a; b] (8), then the gradient
struct PointColumns {
  double* columns = nullptr;  // kNumColumns of them, one behind the other
  double* H = nullptr;        // diagonal
  size_t stride = 0;
};

// Adds the priors r = root (rho - prior_rho), Huber's norm. `points` may have null pointers.
void AddDepthPriors(const double* rho,
                    const double* prior_rho,
                    const double* root,
                    double huber,
                    const PointColumns& points,
                    RobustSum* sum);

// Sets the points' part of the normal equations from a batch of weighted residuals: of one point a
// pixel, from point `first` on, or of one point every kPatternSize pixels.
void SetPoints(const PixelResiduals& residuals,
               const double* weights,
               bool is_pattern,
               size_t first,
               const PointColumns& points);

// Upper triangle, row by row, of the matrix over 9 columns whose rows are weighted and squared:
// sum_i w_i c_i c_i^T.
using Gram = std::array<double, kNumColumns*(kNumColumns + 1) / 2>;
void AddGram(const double* columns, size_t stride, const double* weights, size_t size, Gram* gram);

}  // namespace prism
