// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/camera/plenoptic_camera.h"
#include "prism/scene/frame.h"

namespace prism {

// Turns a frame with an image of virtual points into one with an image of chief rays
// (FocusedImage). The depths that an image was rendered with say which chief ray each of its pixels
// shows, whether they are right or not; they are taken to be the frame's, with gaps filled by
// DenseDepth as LightFieldProcessor does. The image is resampled (bicubic), and measurements move
// with it, to the nearest pixel. `camera` is that of the frame.
LightFieldFrame ToChiefRays(const PlenopticCamera& camera, const LightFieldFrame& frame);

}  // namespace prism
