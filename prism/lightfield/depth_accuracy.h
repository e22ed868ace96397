// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/image/image.h"

namespace prism {

// Accuracy of 1/v over the most certain `percent` of all pixels that have truth. Where fewer are
// measured, all measured ones count (`pixels` says how many).
struct DepthAccuracy {
  double percent = 0;
  long pixels = 0;
  double median_abs_error = 0;
  double median_error = 0;         // estimate - truth
  double fraction_above_0_02 = 0;  // |error| > 0.02
  double normalized_sigma = 0;     // robust standard deviation of error / sigma, 1.4826 MAD about 0
};

// Collects frames with truth.
class DepthAccuracyEvaluator {
 public:
  // Images of one size; 0 = no measurement, no truth.
  void Add(const ImageF& inverse_virtual_depth, const ImageF& sigma, const ImageF& truth);

  bool empty() const { return pixels_with_truth_ == 0; }
  double MeasuredFraction() const;

  // For 5, 10, 25 and 50 %.
  std::vector<DepthAccuracy> Evaluate() const;

 private:
  struct Measurement {
    float sigma;
    float error;
  };
  std::vector<Measurement> measurements_;
  long pixels_with_truth_ = 0;
};

}  // namespace prism
