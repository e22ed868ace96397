// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/camera/plenoptic_camera.h"
#include "prism/lightfield/lens_table.h"
#include "prism/lightfield/preparation.h"
#include "prism/scene/frame.h"

namespace prism {

struct ReprojectionError {
  long pixels = 0;
  double rms = 0;  // of raw - focused image, 0 to 255
};

// How well a totally focused image explains the raw frame it was made from. Every good raw pixel p
// is taken to the virtual point X = (p - c_ML) / w + c_ML (Eqs. (6)-(7)) with w the inverse virtual
// depth there, and compared with the focused image at X. Counted are textured pixels, where the
// focused image's gradient is at least min_gradient per focused px, that have a measured depth and
// no depth edge (a range of 1/v above 0.01) within two focused px. With a perfect focused image the
// RMS is the noise of `raw`. No pixels: rms is 0.
ReprojectionError MeasureReprojection(const PlenopticCamera& camera,
                                      const LensTable& lenses,
                                      const PreparedRaw& raw,
                                      const LightFieldFrame& frame,
                                      const ImageF& dense_inverse_virtual_depth,
                                      double min_gradient);

}  // namespace prism
