// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "prism/camera/plenoptic_camera.h"
#include "prism/image/image.h"
#include "prism/lightfield/lens_table.h"

namespace prism {

// The totally focused image: focused pixel X with inverse virtual depth w shows the mean of the raw
// image at x_R = (X - c_ML) w + c_ML (Eqs. (6)-(7)) over the lenses that see it, weighted by the
// distance r to the micro-image centre, (1 - (r / R)^2)^2, and by how sharp the lens' type is at w.
// A pixel that no lens sees takes the nearest lens' value at its micro image's rim. `raw` is
// PreparedRaw::gray or a channel of RawPreparation::PrepareChannel, `lens_colour` what PreparedRaw
// says of their pixels.
void RenderFocusedImage(const PlenopticCamera& camera,
                        const LensTable& lenses,
                        const ImageF& raw,
                        const Image<uint8_t>& lens_colour,
                        const ImageF& dense_inverse_virtual_depth,
                        ImageF* image);

}  // namespace prism
