// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_accuracy.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>

namespace prism {
namespace {

double Median(std::vector<float>* values) {
  if (values->empty()) return 0;
  auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

void DepthAccuracyEvaluator::Add(const ImageF& inverse_virtual_depth,
                                 const ImageF& sigma,
                                 const ImageF& truth) {
  CHECK_EQ(inverse_virtual_depth.size(), truth.size());
  CHECK_EQ(sigma.size(), truth.size());
  for (size_t i = 0; i < truth.size(); ++i) {
    if (truth.data()[i] == 0) continue;
    ++pixels_with_truth_;
    const float s = sigma.data()[i];
    if (s > 0) measurements_.push_back({s, inverse_virtual_depth.data()[i] - truth.data()[i]});
  }
}

double DepthAccuracyEvaluator::MeasuredFraction() const {
  return pixels_with_truth_ == 0
             ? 0
             : static_cast<double>(measurements_.size()) / static_cast<double>(pixels_with_truth_);
}

std::vector<DepthAccuracy> DepthAccuracyEvaluator::Evaluate() const {
  std::vector<Measurement> sorted = measurements_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Measurement& a, const Measurement& b) {
    return a.sigma < b.sigma;
  });
  std::vector<DepthAccuracy> result;
  for (const double percent : {5.0, 10.0, 25.0, 50.0}) {
    const size_t wanted =
        static_cast<size_t>(percent / 100 * static_cast<double>(pixels_with_truth_));
    const size_t count = std::min(wanted, sorted.size());
    std::vector<float> error, absolute, normalized;
    long above = 0;
    for (size_t i = 0; i < count; ++i) {
      error.push_back(sorted[i].error);
      absolute.push_back(std::abs(sorted[i].error));
      normalized.push_back(absolute.back() / sorted[i].sigma);
      above += absolute.back() > 0.02f;
    }
    DepthAccuracy accuracy;
    accuracy.percent = percent;
    accuracy.pixels = static_cast<long>(count);
    accuracy.median_abs_error = Median(&absolute);
    accuracy.median_error = Median(&error);
    accuracy.fraction_above_0_02 =
        count > 0 ? static_cast<double>(above) / static_cast<double>(count) : 0;
    accuracy.normalized_sigma = 1.4826 * Median(&normalized);
    result.push_back(accuracy);
  }
  return result;
}

}  // namespace prism
