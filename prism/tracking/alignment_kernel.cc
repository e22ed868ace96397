// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/alignment_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/tracking/alignment_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "prism/image/patch.h"

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;

template <class D, class V>
double Sum(D d, V v) {
  return hn::GetLane(hn::SumOfLanes(d, v));
}

void WeighPixelsImpl(const PixelResiduals& residuals,
                     const double* pixel_weight,
                     double huber,
                     double outlier,
                     double* weights,
                     RobustSum* sum) {
  const Doubles d;
  auto energy = hn::Zero(d), visible = hn::Zero(d), inliers = hn::Zero(d);
  const auto limit = hn::Set(d, huber), cut = hn::Set(d, outlier), one = hn::Set(d, 1);
  for (size_t i = 0; i < kPixelBatch; i += hn::Lanes(d)) {
    const auto seen = hn::Load(d, residuals.seen + i);
    const auto r = hn::Abs(hn::Load(d, residuals.value() + i));
    const auto weight = hn::Mul(hn::LoadU(d, pixel_weight + i), seen);
    const auto is_inlier = hn::Le(r, cut);
    const auto q = hn::Min(r, cut);
    const auto m = hn::Min(q, limit);
    energy = hn::MulAdd(hn::Mul(weight, m), hn::Sub(hn::Add(q, q), m), energy);
    visible = hn::Add(visible, seen);
    inliers = hn::Add(inliers, hn::IfThenElseZero(is_inlier, seen));
    if (weights == nullptr) continue;
    const auto robust = hn::IfThenElse(hn::Gt(r, limit), hn::Div(limit, r), one);
    hn::Store(hn::IfThenElseZero(is_inlier, hn::Mul(weight, robust)), d, weights + i);
  }
  sum->energy += Sum(d, energy);
  sum->visible += Sum(d, visible);
  sum->inliers += Sum(d, inliers);
}

void AddDepthPriorsImpl(const double* rho,
                        const double* prior_rho,
                        const double* root_of,
                        double huber,
                        const PointColumns& points,
                        RobustSum* sum) {
  const Doubles d;
  auto energy = hn::Zero(d);
  const auto limit = hn::Set(d, huber), one = hn::Set(d, 1);
  double* const gradient =
      points.H != nullptr ? points.columns + (kNumColumns - 1) * points.stride : nullptr;
  for (size_t i = 0; i < points.stride; i += hn::Lanes(d)) {
    const auto root = hn::LoadU(d, root_of + i);
    const auto is_known = hn::Gt(root, hn::Zero(d));
    const auto difference = hn::Sub(hn::LoadU(d, rho + i), hn::LoadU(d, prior_rho + i));
    const auto r = hn::IfThenElseZero(is_known, hn::Mul(root, difference));
    const auto magnitude = hn::Abs(r);
    const auto m = hn::Min(magnitude, limit);
    energy = hn::MulAdd(m, hn::Sub(hn::Add(magnitude, magnitude), m), energy);
    if (points.H == nullptr) continue;
    const auto robust = hn::IfThenElse(hn::Gt(magnitude, limit), hn::Div(limit, magnitude), one);
    const auto weighted = hn::Mul(robust, root);
    hn::StoreU(hn::MulAdd(weighted, root, hn::LoadU(d, points.H + i)), d, points.H + i);
    hn::StoreU(hn::MulAdd(weighted, r, hn::LoadU(d, gradient + i)), d, gradient + i);
  }
  sum->energy += Sum(d, energy);
}

void SetPointsImpl(const PixelResiduals& residuals,
                   const double* weights,
                   bool is_pattern,
                   size_t first,
                   const PointColumns& points) {
  const Doubles d;
  alignas(64) double weighted[kPixelBatch];  // Jacobians over rho
  for (size_t i = 0; i < kPixelBatch; i += hn::Lanes(d)) {
    hn::Store(hn::Mul(hn::Load(d, weights + i), hn::Load(d, residuals.J_rho + i)), d, weighted + i);
  }
  const auto set = [&](const double* factor, double* out) {
    if (!is_pattern) {
      for (size_t i = 0; i < kPixelBatch; i += hn::Lanes(d)) {
        hn::StoreU(hn::Mul(hn::Load(d, weighted + i), hn::Load(d, factor + i)), d, out + first + i);
      }
      return;
    }
    for (size_t i = 0; i < kPixelBatch; i += kPatternSize) {
      auto sum = hn::Zero(d);
      for (size_t k = i; k < i + kPatternSize; k += hn::Lanes(d)) {
        sum = hn::MulAdd(hn::Load(d, weighted + k), hn::Load(d, factor + k), sum);
      }
      out[first + i / kPatternSize] = Sum(d, sum);
    }
  };
  for (int k = 0; k < kNumColumns; ++k) set(residuals.rows[k], points.columns + k * points.stride);
  set(residuals.J_rho, points.H);
}

// Weighted products of one column with four, or as many as follow.
void AddProducts(const double* column,
                 const double* others,
                 size_t stride,
                 size_t count,
                 const double* weights,
                 size_t size,
                 double* sums) {
  const Doubles d;
  auto sum0 = hn::Zero(d), sum1 = hn::Zero(d), sum2 = hn::Zero(d), sum3 = hn::Zero(d);
  const double* const other1 = others + (count > 1 ? stride : 0);
  const double* const other2 = others + (count > 2 ? 2 * stride : 0);
  const double* const other3 = others + (count > 3 ? 3 * stride : 0);
  for (size_t i = 0; i < size; i += hn::Lanes(d)) {
    const auto weighted = hn::Mul(hn::LoadU(d, weights + i), hn::LoadU(d, column + i));
    sum0 = hn::MulAdd(weighted, hn::LoadU(d, others + i), sum0);
    sum1 = hn::MulAdd(weighted, hn::LoadU(d, other1 + i), sum1);
    sum2 = hn::MulAdd(weighted, hn::LoadU(d, other2 + i), sum2);
    sum3 = hn::MulAdd(weighted, hn::LoadU(d, other3 + i), sum3);
  }
  sums[0] += Sum(d, sum0);
  if (count > 1) sums[1] += Sum(d, sum1);
  if (count > 2) sums[2] += Sum(d, sum2);
  if (count > 3) sums[3] += Sum(d, sum3);
}

void AddGramImpl(
    const double* columns, size_t stride, const double* weights, size_t size, double* upper) {
  for (size_t row = 0; row < kNumColumns; ++row) {
    const double* const column = columns + row * stride;
    for (size_t k = row; k < kNumColumns; k += 4) {
      const size_t count = std::min<size_t>(kNumColumns - k, 4);
      AddProducts(column, columns + k * stride, stride, count, weights, size, upper);
      upper += count;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(WeighPixelsImpl);
HWY_EXPORT(AddDepthPriorsImpl);
HWY_EXPORT(SetPointsImpl);
HWY_EXPORT(AddGramImpl);

void WeighPixels(const PixelResiduals& residuals,
                 const double* pixel_weight,
                 double huber,
                 double outlier,
                 double* weights,
                 RobustSum* sum) {
  HWY_DYNAMIC_DISPATCH(WeighPixelsImpl)(residuals, pixel_weight, huber, outlier, weights, sum);
}

void AddDepthPriors(const double* rho,
                    const double* prior_rho,
                    const double* root,
                    double huber,
                    const PointColumns& points,
                    RobustSum* sum) {
  HWY_DYNAMIC_DISPATCH(AddDepthPriorsImpl)(rho, prior_rho, root, huber, points, sum);
}

void SetPoints(const PixelResiduals& residuals,
               const double* weights,
               bool is_pattern,
               size_t first,
               const PointColumns& points) {
  HWY_DYNAMIC_DISPATCH(SetPointsImpl)(residuals, weights, is_pattern, first, points);
}

void AddGram(const double* columns, size_t stride, const double* weights, size_t size, Gram* gram) {
  HWY_DYNAMIC_DISPATCH(AddGramImpl)(columns, stride, weights, size, gram->data());
}

}  // namespace prism
#endif  // HWY_ONCE
