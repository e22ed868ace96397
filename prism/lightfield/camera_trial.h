// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/scene/frame.h"

namespace prism {

// How well a camera explains a raw frame: what is compared where files leave something open (the
// order of lens types, the sign of a rotation, the mode) and the frame itself can tell.
struct CameraTrial {
  double measured = 0;         // share of the pixels at which lenses agree on a depth
  double information = 0;      // mean over all pixels of 1 / sigma^2 of 1/v, 0 where not measured
  double gradient_energy = 0;  // mean over all pixels of the focused image's squared gradient
};

// Processes the frame with the camera. Preconditions as of LightFieldProcessor.
CameraTrial TryCamera(const PlenopticCamera& camera,
                      const cv::Mat& white,
                      const LightFieldOptions& options,
                      const RawFrame& frame);

}  // namespace prism
