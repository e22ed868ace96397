// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/camera_trial.h"

#include <numeric>

namespace prism {

CameraTrial TryCamera(const PlenopticCamera& camera,
                      const cv::Mat& white,
                      const LightFieldOptions& options,
                      const RawFrame& frame) {
  const LightFieldFrame result = LightFieldProcessor(camera, white, options).Process(frame);
  const double pixels = static_cast<double>(result.sigma.size());
  CameraTrial trial;
  for (size_t i = 0; i < result.sigma.size(); ++i) {
    const double sigma = result.sigma.data()[i];
    if (sigma == 0) continue;
    trial.measured += 1 / pixels;
    trial.information += 1 / (sigma * sigma) / pixels;
  }
  const ImageF energy = SquaredGradientMagnitude(result.image[0]);
  trial.gradient_energy =
      std::accumulate(energy.data(), energy.data() + energy.size(), 0.0) / pixels;
  return trial;
}

}  // namespace prism
