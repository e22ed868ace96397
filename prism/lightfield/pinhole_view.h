// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/image/image.h"
#include "prism/scene/frame.h"

namespace prism {

struct PinholeFrame {
  ImageF image;    // gray, 0 to 255
  cv::Mat colour;  // BGR, 8 bits; empty where the frame has none
  ImageF depth;    // metres along the optical axis; 0 = no measurement
};

// The pinhole view of supplement Section F: each pixel x_p of the plane 2B behind the micro-lens
// array (intrinsics: PinholeView) looks for the virtual point on its ray, Eqs. (88)-(89) solved for
// x'_V by fixed-point iteration over the dense depth, and shows the focused image there. The depth
// is measured depth only, of the nearest focused pixel; points at or beyond infinity have none.
PinholeFrame MakePinholeView(const PlenopticCamera& camera,
                             const LightFieldFrame& frame,
                             const ImageF& dense_inverse_virtual_depth);

// The intrinsics cropped about the principal point to a horizontal and vertical field of view
// (Section H); never larger than the camera. `left` and `top` are the crop's corner.
// Precondition: 0 < fov_deg < 180.
PinholeCamera CropToFieldOfView(const PinholeCamera& camera, double fov_deg, int* left, int* top);

}  // namespace prism
