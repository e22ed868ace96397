// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/normal_variates.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace prism {
namespace {

constexpr int kQuantiles = 65536;

// The distribution function is concave above 0, so that Newton's method comes from below.
double NextQuantile(double probability, double below) {
  double value = below, step = 1;
  while (step > 1e-7) {
    const double reached = 0.5 * std::erfc(-value / std::sqrt(2));
    const double density = std::exp(-0.5 * value * value) / std::sqrt(2 * M_PI);
    step = (probability - reached) / density;
    value += step;
  }
  return value;
}

std::vector<float> MakeQuantiles() {
  std::vector<float> quantiles(kQuantiles);
  double value = 0;
  for (size_t k = kQuantiles / 2; k < kQuantiles; ++k) {
    value = NextQuantile((static_cast<double>(k) + 0.5) / kQuantiles, value);
    quantiles[k] = static_cast<float>(value);
    quantiles[kQuantiles - 1 - k] = -quantiles[k];
  }
  return quantiles;
}

}  // namespace

void NormalVariates::Fill(float* values, size_t count) {
  static const std::vector<float> quantiles = MakeQuantiles();
  const float* table = quantiles.data();
  constexpr size_t kPerDraw = 4;
  choices_.resize((count + kPerDraw - 1) / kPerDraw * kPerDraw);
  for (size_t i = 0; i < choices_.size(); i += kPerDraw) {
    const uint64_t draw = generator_();
    std::memcpy(&choices_[i], &draw, sizeof(draw));
  }
  for (size_t i = 0; i < count; ++i) values[i] = table[choices_[i]];
}

}  // namespace prism
