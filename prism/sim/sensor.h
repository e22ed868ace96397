// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core/mat.hpp>

namespace prism {

enum class SensorColour { kGray, kColour, kBayerRggb };

struct SensorOptions {
  SensorColour colour = SensorColour::kGray;  // kColour: BGR, no mosaic
  int bits = 8;                               // 8 to 16; more than 8 go to full-range 16 bits
  double full_well_electrons = 8000;          // charge at full scale; 0: no noise at all
  double read_noise_electrons = 8;            // standard deviation
  uint64_t seed = 1;                          // of the noise

  bool IsValid(std::string* error) const;
};

// What the sensor reads for an image of radiance (CV_32FC3 BGR or CV_32FC1): full scale is reached
// at radiance * gain = 1. Shot noise (Poisson, as a Gaussian of equal variance) and read noise,
// then clipping and quantisation. Noise depends on (seed, frame, pixel) alone. CV_8U for 8 bits;
// else CV_16U whose 2^bits values are spread over 0 to 65535.
cv::Mat ReadSensor(const cv::Mat& radiance,
                   double gain,
                   const SensorOptions& options,
                   uint64_t frame);

}  // namespace prism
