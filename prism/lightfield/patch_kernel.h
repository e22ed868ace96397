// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "prism/lightfield/half_pixel_image.h"

namespace prism {

inline constexpr int kPatchRadius = 3;  // px of the raw image: patches of 7 x 7
inline constexpr int kPatchLanes = 8;   // a patch row as it is loaded; the last lane has weight 0

// Weights of the rows and columns of a patch: exp(-d^2 / (2 sigma^2)) of the distance from its
// centre.
inline constexpr float kPatchSigma = 2;  // px
alignas(64) inline constexpr float kPatchWeights[kPatchLanes] = {
    0.32465247f, 0.60653066f, 0.88249690f, 1.0f, 0.88249690f, 0.60653066f, 0.32465247f, 0.0f};

// One lens' sight of a patch, by what surrounds the patch's top-left sample.
struct PatchSample {
  HalfPixelImage::Cell image;
  HalfPixelImage::Cell blurred;  // at the same position; read where blend > 0
  float blend;                   // values are image + blend (blurred - image)
  const uint8_t* colours;        // of the whole pixel up and left of the sample
  float dx, dy;                  // motion of the patch per unit of 1/v, px
  uint8_t colour;                // samples whose colour differs are left out
};

// Sums over the samples s of a patch and the n_s lenses k that see it, with patch weight p_s, value
// I_ks, derivative g_ks = dI_ks / d(1/v), means over the lenses I_s and g_s:
//   cost     = sum p (I - I_s)^2     gradient = sum p (g - g_s)(I - I_s)
//   hessian  = sum p (g - g_s)^2     freedom  = sum_s p_s (n_s - 1), n_s > 0
// and the sums of hessian's terms times their distance in x and in y from the patch's centre, px:
// over hessian, where in the patch the texture lies. The cost is minimised over 1/v by the step
// -gradient / hessian. A common brightness change of the patch cancels only between lenses, not
// within; each sample has its own mean.
struct PatchSums {
  float cost;
  float gradient;
  float hessian;
  float freedom;
  float moment_x, moment_y;
};

// Vectorised, best instruction set at run time. Precondition: every row of every patch has
// kPatchLanes + 1 readable pixels, and there are 2 * kPatchRadius + 2 rows.
PatchSums SumPatches(const PatchSample* samples, int count, std::ptrdiff_t stride);

// The same without gradient, hessian and its moments, which are 0.
PatchSums SumPatchCosts(const PatchSample* samples, int count, std::ptrdiff_t stride);

// One lens' sight of a patch at the nearest half pixel.
struct CoarseSample {
  const float* image;    // at the patch's top-left sample
  const float* blurred;  // read where blend > 0
  float blend;
  const uint8_t* colours;
  uint8_t colour;
};

// Cost and freedom of every second row at the nearest half pixels, brought to what they would be of
// all rows. A quarter of the work, for a search; what is misplaced by up to a quarter of a pixel
// adds to the cost where there is texture.
PatchSums SumCoarsePatchCosts(const CoarseSample* samples, int count, std::ptrdiff_t stride);

// The same in plain C++; the oracle of the test.
PatchSums SumPatchesReference(const PatchSample* samples, int count, std::ptrdiff_t stride);

}  // namespace prism
