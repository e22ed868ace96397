// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/solver/gram_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/solver/gram_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void UpperGramImpl(const double* A, size_t num_rows, size_t width, size_t stride, double* gram) {
  const hn::CappedTag<double, kGramLanes> d;
  for (size_t i = 0; i < width; i += 4) {
    for (size_t j = i; j < width; j += hn::Lanes(d)) {
      auto sum0 = hn::Zero(d), sum1 = hn::Zero(d), sum2 = hn::Zero(d), sum3 = hn::Zero(d);
      const double* row = A;
      for (size_t k = 0; k < num_rows; ++k, row += stride) {
        const auto right = hn::LoadU(d, row + j);
        sum0 = hn::MulAdd(hn::Set(d, row[i]), right, sum0);
        sum1 = hn::MulAdd(hn::Set(d, row[i + 1]), right, sum1);
        sum2 = hn::MulAdd(hn::Set(d, row[i + 2]), right, sum2);
        sum3 = hn::MulAdd(hn::Set(d, row[i + 3]), right, sum3);
      }
      hn::StoreU(sum0, d, gram + i * stride + j);
      hn::StoreU(sum1, d, gram + (i + 1) * stride + j);
      hn::StoreU(sum2, d, gram + (i + 2) * stride + j);
      hn::StoreU(sum3, d, gram + (i + 3) * stride + j);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(UpperGramImpl);

void UpperGram(const double* A, size_t num_rows, size_t width, size_t stride, double* gram) {
  HWY_DYNAMIC_DISPATCH(UpperGramImpl)(A, num_rows, width, stride, gram);
}

}  // namespace prism
#endif  // HWY_ONCE
