// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/patch_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/lightfield/patch_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Weight of all rows over that of every second.
constexpr float CoarseRowsShare() {
  float all = 0, coarse = 0;
  for (int row = 0; row <= 2 * kPatchRadius; ++row) {
    all += kPatchWeights[row];
    if (row % 2 == 0) coarse += kPatchWeights[row];
  }
  return all / coarse;
}

template <class D>
hn::Vec<D> LoadBlended(D d, const PatchSample& sample, int corner, std::ptrdiff_t offset) {
  const auto sharp = hn::LoadU(d, sample.image.corner[corner] + offset);
  if (sample.blend == 0) return sharp;
  const auto blurred = hn::LoadU(d, sample.blurred.corner[corner] + offset);
  return hn::MulAdd(hn::Set(d, sample.blend), hn::Sub(blurred, sharp), sharp);
}

// Lanes whose colour is `colour`.
template <class D>
hn::Mask<D> IsColour(D d, const uint8_t* colours, uint8_t colour) {
  const hn::RebindToSigned<D> di;
  const auto found = hn::PromoteTo(di, hn::LoadU(hn::Rebind<uint8_t, D>(), colours));
  return hn::RebindMask(d, hn::Eq(found, hn::Set(di, colour)));
}

template <bool kDerivatives>
PatchSums Sum(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  constexpr int kRows = 2 * kPatchRadius + 1;
  constexpr float kSteps = HalfPixelImage::kStepsPerPixel;
  const hn::CappedTag<float, kPatchLanes> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0f);
  float cost = 0, gradient = 0, hessian = 0, freedom = 0, moment_x = 0, moment_y = 0;
  // One pass on vectors of 8 lanes, two on vectors of 4.
  for (size_t lane = 0; lane < kPatchLanes; lane += hn::Lanes(d)) {
    V cost_sum = zero, gradient_sum = zero, hessian_sum = zero, freedom_sum = zero;
    V moment_y_sum = zero;
    const V column_weight = hn::Load(d, kPatchWeights + lane);
    for (int row = 0; row < kRows; ++row) {
      V sum_q = zero, sum_i = zero, sum_g = zero;
      V sum_ii = zero, sum_gi = zero, sum_gg = zero;
      // Values relative to the first lens' keep the sums of squares small.
      V origin = zero;
      for (int k = 0; k < count; ++k) {
        const PatchSample& sample = samples[k];
        const std::ptrdiff_t p = row * stride + static_cast<std::ptrdiff_t>(lane);
        const V v00 = LoadBlended(d, sample, 0, p);
        const V v10 = LoadBlended(d, sample, 1, p);
        const V v01 = LoadBlended(d, sample, 2, p);
        const V v11 = LoadBlended(d, sample, 3, p);
        const V fx = hn::Set(d, sample.image.fx);
        const V fy = hn::Set(d, sample.image.fy);
        const V dx_top = hn::Sub(v10, v00);
        const V dx_bottom = hn::Sub(v11, v01);
        const V top = hn::MulAdd(fx, dx_top, v00);
        const V bottom = hn::MulAdd(fx, dx_bottom, v01);
        const V dy = hn::Sub(bottom, top);
        V value = hn::MulAdd(fy, dy, top);
        if (k == 0) origin = value;
        value = hn::Sub(value, origin);
        const auto good = IsColour(d, sample.colours + p, sample.colour);
        value = hn::IfThenElseZero(good, value);
        sum_q = hn::Add(sum_q, hn::IfThenElseZero(good, one));
        sum_i = hn::Add(sum_i, value);
        sum_ii = hn::MulAdd(value, value, sum_ii);
        if (kDerivatives) {
          const V dx = hn::MulAdd(fy, hn::Sub(dx_bottom, dx_top), dx_top);
          const V g = hn::IfThenElseZero(
              good,
              hn::MulAdd(
                  dx, hn::Set(d, kSteps * sample.dx), hn::Mul(dy, hn::Set(d, kSteps * sample.dy))));
          sum_g = hn::Add(sum_g, g);
          sum_gi = hn::MulAdd(g, value, sum_gi);
          sum_gg = hn::MulAdd(g, g, sum_gg);
        }
      }
      const V weight = hn::Mul(column_weight, hn::Set(d, kPatchWeights[row]));
      const V inverse_q = hn::Div(one, hn::Max(sum_q, one));
      const V mean_i = hn::Mul(sum_i, inverse_q);
      cost_sum = hn::MulAdd(weight, hn::NegMulAdd(mean_i, sum_i, sum_ii), cost_sum);
      freedom_sum = hn::MulAdd(weight, hn::Max(hn::Sub(sum_q, one), zero), freedom_sum);
      if (kDerivatives) {
        const V mean_g = hn::Mul(sum_g, inverse_q);
        gradient_sum = hn::MulAdd(weight, hn::NegMulAdd(mean_g, sum_i, sum_gi), gradient_sum);
        const V row_hessian = hn::Mul(weight, hn::NegMulAdd(mean_g, sum_g, sum_gg));
        hessian_sum = hn::Add(hessian_sum, row_hessian);
        moment_y_sum = hn::MulAdd(
            row_hessian, hn::Set(d, static_cast<float>(row - kPatchRadius)), moment_y_sum);
      }
    }
    cost += hn::GetLane(hn::SumOfLanes(d, cost_sum));
    freedom += hn::GetLane(hn::SumOfLanes(d, freedom_sum));
    if (kDerivatives) {
      gradient += hn::GetLane(hn::SumOfLanes(d, gradient_sum));
      hessian += hn::GetLane(hn::SumOfLanes(d, hessian_sum));
      const V column = hn::Iota(d, static_cast<float>(lane) - static_cast<float>(kPatchRadius));
      moment_x += hn::GetLane(hn::SumOfLanes(d, hn::Mul(column, hessian_sum)));
      moment_y += hn::GetLane(hn::SumOfLanes(d, moment_y_sum));
    }
  }
  return {cost, gradient, hessian, freedom, moment_x, moment_y};
}

PatchSums SumCoarsePatchCostsImpl(const CoarseSample* samples, int count, std::ptrdiff_t stride) {
  const hn::CappedTag<float, kPatchLanes> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0f);
  float cost = 0, freedom = 0;
  for (size_t lane = 0; lane < kPatchLanes; lane += hn::Lanes(d)) {
    V cost_sum = zero, freedom_sum = zero;
    for (int row = 0; row <= 2 * kPatchRadius; row += 2) {
      const std::ptrdiff_t p = row * stride + static_cast<std::ptrdiff_t>(lane);
      V sum_q = zero, sum_i = zero, sum_ii = zero;
      V origin = zero;
      for (int k = 0; k < count; ++k) {
        const CoarseSample& sample = samples[k];
        V value = hn::LoadU(d, sample.image + p);
        if (sample.blend > 0) {
          const V blurred = hn::LoadU(d, sample.blurred + p);
          value = hn::MulAdd(hn::Set(d, sample.blend), hn::Sub(blurred, value), value);
        }
        if (k == 0) origin = value;
        const auto good = IsColour(d, sample.colours + p, sample.colour);
        value = hn::IfThenElseZero(good, hn::Sub(value, origin));
        sum_q = hn::Add(sum_q, hn::IfThenElseZero(good, one));
        sum_i = hn::Add(sum_i, value);
        sum_ii = hn::MulAdd(value, value, sum_ii);
      }
      const V weight = hn::Set(d, kPatchWeights[row]);
      const V mean_i = hn::Div(sum_i, hn::Max(sum_q, one));
      cost_sum = hn::MulAdd(weight, hn::NegMulAdd(mean_i, sum_i, sum_ii), cost_sum);
      freedom_sum = hn::MulAdd(weight, hn::Max(hn::Sub(sum_q, one), zero), freedom_sum);
    }
    const V column_weight = hn::Load(d, kPatchWeights + lane);
    cost += hn::GetLane(hn::SumOfLanes(d, hn::Mul(column_weight, cost_sum)));
    freedom += hn::GetLane(hn::SumOfLanes(d, hn::Mul(column_weight, freedom_sum)));
  }
  constexpr float kShare = CoarseRowsShare();
  return {kShare * cost, 0, 0, kShare * freedom, 0, 0};
}

PatchSums SumPatchesImpl(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  return Sum<true>(samples, count, stride);
}

PatchSums SumPatchCostsImpl(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  return Sum<false>(samples, count, stride);
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(SumPatchesImpl);
HWY_EXPORT(SumPatchCostsImpl);
HWY_EXPORT(SumCoarsePatchCostsImpl);

PatchSums SumPatches(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  return HWY_DYNAMIC_DISPATCH(SumPatchesImpl)(samples, count, stride);
}

PatchSums SumPatchCosts(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  return HWY_DYNAMIC_DISPATCH(SumPatchCostsImpl)(samples, count, stride);
}

PatchSums SumCoarsePatchCosts(const CoarseSample* samples, int count, std::ptrdiff_t stride) {
  return HWY_DYNAMIC_DISPATCH(SumCoarsePatchCostsImpl)(samples, count, stride);
}

PatchSums SumPatchesReference(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  double cost = 0, gradient = 0, hessian = 0, freedom = 0, moment_x = 0, moment_y = 0;
  for (int row = 0; row <= 2 * kPatchRadius; ++row) {
    for (int column = 0; column <= 2 * kPatchRadius; ++column) {
      double sum_q = 0, sum_i = 0, sum_g = 0, sum_ii = 0, sum_gi = 0, sum_gg = 0;
      for (int k = 0; k < count; ++k) {
        const PatchSample& s = samples[k];
        if (s.colours[row * stride + column] != s.colour) continue;
        const std::ptrdiff_t p = row * stride + column;
        const auto value_at = [&](int corner) -> double {
          const double sharp = s.image.corner[corner][p];
          return s.blend == 0 ? sharp : sharp + s.blend * (s.blurred.corner[corner][p] - sharp);
        };
        const double fx = s.image.fx, fy = s.image.fy;
        const double v00 = value_at(0), v10 = value_at(1), v01 = value_at(2), v11 = value_at(3);
        const double top = v00 + fx * (v10 - v00);
        const double bottom = v01 + fx * (v11 - v01);
        const double dx = (1 - fy) * (v10 - v00) + fy * (v11 - v01);
        const double value = top + fy * (bottom - top);
        const double g = HalfPixelImage::kStepsPerPixel * (dx * s.dx + (bottom - top) * s.dy);
        sum_q += 1;
        sum_i += value;
        sum_g += g;
        sum_ii += value * value;
        sum_gi += g * value;
        sum_gg += g * g;
      }
      if (sum_q <= 0) continue;
      const double weight = kPatchWeights[row] * kPatchWeights[column];
      cost += weight * (sum_ii - sum_i * sum_i / sum_q);
      gradient += weight * (sum_gi - sum_g * sum_i / sum_q);
      const double term = weight * (sum_gg - sum_g * sum_g / sum_q);
      hessian += term;
      moment_x += term * (column - kPatchRadius);
      moment_y += term * (row - kPatchRadius);
      freedom += weight * (sum_q - 1);
    }
  }
  return {static_cast<float>(cost),
          static_cast<float>(gradient),
          static_cast<float>(hessian),
          static_cast<float>(freedom),
          static_cast<float>(moment_x),
          static_cast<float>(moment_y)};
}

}  // namespace prism
#endif  // HWY_ONCE
