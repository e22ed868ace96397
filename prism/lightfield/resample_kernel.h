// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "prism/image/image.h"
#include "prism/lightfield/lens_table.h"

namespace prism {

inline constexpr int kResampleLanes = 8;  // virtual points of a run

// Neighbouring virtual points (X[i], Y[i]), raw px, with their LensTable::Magnification w[i].
struct VirtualPointRun {
  alignas(64) float X[kResampleLanes];
  alignas(64) float Y[kResampleLanes];
  alignas(64) float w[kResampleLanes];
};

// Adds to `sum` and `weight` of each point of the run what one lens sees of it: its raw image,
// bilinear, at x_R = (X - c_ML) w + c_ML (Eqs. (6)-(7)), weighted by sharpness[i]
// (1.001 - (r / radius)^2)^2 with r the distance from the micro-image centre, and by a thousandth
// of that where `colours` at the pixel is not the lens' (masked pixels count where nothing else is
// seen). Nothing is added beyond the radius or the image. Vectorised, best instruction set at run
// time. `sum`, `weight` and `sharpness` have kResampleLanes elements, aligned to 64 bytes.
void ResampleLens(const Lens& lens,
                  const ImageF& raw,
                  const Image<uint8_t>& colours,
                  float radius_px,
                  const VirtualPointRun& run,
                  const float* sharpness,
                  float* sum,
                  float* weight);

}  // namespace prism
