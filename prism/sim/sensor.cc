// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/sensor.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "prism/sim/counter_random.h"

namespace prism {
namespace {

// Red at even columns of even rows, blue at odd ones of odd rows.
cv::Mat Mosaic(const cv::Mat& bgr) {
  cv::Mat mosaic(bgr.size(), CV_32FC1);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      mosaic.at<float>(y, x) = bgr.at<cv::Vec3f>(y, x)[2 - (x & 1) - (y & 1)];
    }
  }
  return mosaic;
}

cv::Mat Channels(const cv::Mat& radiance, SensorColour colour) {
  if (radiance.channels() == 1 || colour == SensorColour::kColour) return radiance;
  if (colour == SensorColour::kBayerRggb) return Mosaic(radiance);
  cv::Mat gray;
  cv::cvtColor(radiance, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

double Gaussian(CounterRandom* random) {
  const double u = 1 - static_cast<double>(random->Uniform());
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * random->Uniform());
}

}  // namespace

bool SensorOptions::IsValid(std::string* error) const {
  if (bits < 8 || bits > 16) {
    *error = std::to_string(bits) + " bits, expected 8 to 16";
  } else if (!(full_well_electrons >= 0 && std::isfinite(full_well_electrons))) {
    *error = "a full well of " + std::to_string(full_well_electrons) + " electrons, expected >= 0";
  } else if (!(read_noise_electrons >= 0 && std::isfinite(read_noise_electrons))) {
    *error = "read noise of " + std::to_string(read_noise_electrons) + " electrons, expected >= 0";
  } else {
    return true;
  }
  return false;
}

cv::Mat ReadSensor(const cv::Mat& radiance,
                   double gain,
                   const SensorOptions& options,
                   uint64_t frame) {
  const cv::Mat signal = Channels(radiance, options.colour);
  const int channels = signal.channels();
  const double levels = std::ldexp(1.0, options.bits) - 1;
  const double step = options.bits == 8 ? 1 : 65535 / levels;
  const double well = options.full_well_electrons;
  cv::Mat image(signal.size(), CV_MAKETYPE(options.bits == 8 ? CV_8U : CV_16U, channels));
  tbb::parallel_for(0, image.rows, [&](int y) {
    const auto* in = signal.ptr<float>(y);
    for (int i = 0; i < image.cols * channels; ++i) {
      double value = std::min(gain * static_cast<double>(in[i]), 4.0);
      if (well > 0) {
        CounterRandom random(
            options.seed, frame, (static_cast<uint64_t>(y) << 32) | static_cast<uint32_t>(i));
        const double sigma = std::sqrt(value * well + std::pow(options.read_noise_electrons, 2));
        value += sigma / well * Gaussian(&random);
      }
      const double level = std::round(std::clamp(value, 0.0, 1.0) * levels) * step;
      if (options.bits == 8) {
        image.ptr<uint8_t>(y)[i] = static_cast<uint8_t>(level);
      } else {
        image.ptr<uint16_t>(y)[i] = static_cast<uint16_t>(std::lround(level));
      }
    }
  });
  return image;
}

}  // namespace prism
