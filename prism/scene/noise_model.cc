// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/scene/noise_model.h"

#include <algorithm>
#include <cmath>

#include "prism/base/statistics.h"

namespace prism {

NoiseModel::NoiseModel(double image_sigma, double model_sigma)
    : image_sigma_(image_sigma), model_sigma_(model_sigma) {}

double NoiseModel::ResidualSigma() const {
  return std::hypot(std::sqrt(2.0) * image_sigma_, model_sigma_);
}

double NoiseModel::Misfit() const {
  constexpr double kLeast = 1.25;
  return std::max(Quantile(misfits_, 0.5), kLeast);
}

void NoiseModel::Observe(double rms) {
  constexpr size_t kFrames = 30;
  misfits_.push_back(rms / ResidualSigma());
  if (misfits_.size() > kFrames) misfits_.erase(misfits_.begin());
}

}  // namespace prism
