// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/scene/noise_model.h"

#include <algorithm>
#include <cmath>

#include "prism/base/statistics.h"

namespace prism {

namespace {

void KeepLast(size_t count, double value, std::vector<double>* values) {
  values->push_back(value);
  if (values->size() > count) values->erase(values->begin());
}

}  // namespace

NoiseModel::NoiseModel(double image_sigma, double model_sigma)
    : image_sigma_(image_sigma), model_sigma_(model_sigma) {}

double NoiseModel::StatedSigma() const {
  return std::hypot(std::sqrt(2.0) * image_sigma_, model_sigma_);
}

double NoiseModel::ResidualSigma() const { return photometric_scale_ * StatedSigma(); }

void NoiseModel::ObserveWindow(double photometric_variance_factor, double depth_variance_factor) {
  // Of the way in the logarithm, a keyframe.
  constexpr double kRate = 0.1;
  const auto follow = [](double variance_factor, double least, double most, double* scale) {
    if (!(variance_factor > 0)) return;
    *scale = std::clamp(*scale * std::pow(variance_factor, 0.5 * kRate), least, most);
  };
  follow(photometric_variance_factor, 0.4, 3, &photometric_scale_);
  follow(depth_variance_factor, 0.5, 2, &depth_scale_);
}

void NoiseModel::ObserveDepthOffsets(double expected_square) {
  constexpr double kRate = 0.1;  // of the way, a keyframe
  if (!(expected_square > 0)) return;
  const double variance = depth_offset_sigma_ * depth_offset_sigma_;
  depth_offset_sigma_ =
      std::clamp(std::sqrt(variance + kRate * (expected_square - variance)), 0.0001, 0.003);
}

double NoiseModel::Misfit() const {
  constexpr double kLeast = 1.25;
  return wider_fit_ * std::max(Quantile(misfits_, 0.5), kLeast);
}

NoiseModel NoiseModel::WithWiderFit(double factor) const {
  NoiseModel wider = *this;
  wider.wider_fit_ *= factor;
  return wider;
}

void NoiseModel::Observe(double rms) { KeepLast(30, rms / StatedSigma(), &misfits_); }

void NoiseModel::ObserveDepthAgreement(double agreement) {
  KeepLast(5, agreement, &depth_agreements_);
}

double NoiseModel::UsualDepthAgreement() const {
  return depth_agreements_.empty() ? 1 : Quantile(depth_agreements_, 0.5);
}

}  // namespace prism
