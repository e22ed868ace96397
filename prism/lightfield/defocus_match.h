// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/lightfield/lens_table.h"

namespace prism {

// Which lens types of an array with several focal lengths are compared at 1/v = w, and how much
// each is blurred so that all are equally blurred.
//
// A round micro lens of radius R (raw px) focused on 1/v_k spreads a point at w over a disc of
// radius R |w - 1/v_k|, whose variance in x and in y is R^2 / 4 (w - 1/v_k)^2. Types whose variance
// exceeds the least by more than kFilterVariance are left out, the others are blurred to the
// largest among them: sharp against blurred images match best beside the truth.
class DefocusMatch {
 public:
  // `focus`: 1/v_k of up to three types; `defocus_variance`: R^2 / 4 (LensTable::DefocusVariance).
  DefocusMatch(const std::vector<float>& focus, float defocus_variance, float w);

  bool Uses(int type) const { return (types_ >> type & 1u) != 0; }
  unsigned types() const { return types_; }  // bit k: type k is used
  // How far, 0 to 1, a used type is blended from SmoothRows::smooth to SmoothRows::smoother.
  float Blend(int type) const { return blend_[type]; }

 private:
  static constexpr int kMaxTypes = 3;
  unsigned types_ = 0;
  float blend_[kMaxTypes];
};

// Lenses that are compared when a depth is refined.
inline constexpr int kMaxComparedViews = 10;

}  // namespace prism
