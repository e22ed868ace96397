// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/patch_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/lightfield/patch_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PRISM_LIGHTFIELD_PATCH_WEIGHTS
#define PRISM_LIGHTFIELD_PATCH_WEIGHTS
namespace prism {
// exp(-d^2 / (2 * 2^2)) of the distance from the patch centre; lane 7 is padding.
alignas(64) inline constexpr float kPatchWeights[8] = {
    0.32465247f, 0.60653066f, 0.88249690f, 1.0f, 0.88249690f, 0.60653066f, 0.32465247f, 0.0f};
}  // namespace prism
#endif

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

PatchSums SumPatchesImpl(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  const hn::CappedTag<float, kPatchLanes> d;
  const auto zero = hn::Zero(d);
  float cost = 0, gradient = 0, hessian = 0, freedom = 0;
  // One pass on vectors of 8 lanes, two on vectors of 4.
  for (size_t lane = 0; lane < kPatchLanes; lane += hn::Lanes(d)) {
    auto cost_sum = zero, gradient_sum = zero, hessian_sum = zero, freedom_sum = zero;
    const auto column_weight = hn::Load(d, kPatchWeights + lane);
    for (int row = 0; row <= 2 * kPatchRadius; ++row) {
      auto sum_q = zero, max_q = zero, sum_i = zero, sum_g = zero;
      auto sum_ii = zero, sum_gi = zero, sum_gg = zero;
      // Values relative to the first lens' keep the sums of squares small.
      auto origin = zero;
      for (int k = 0; k < count; ++k) {
        const PatchSample& sample = samples[k];
        const float* p = sample.image + row * stride + lane;
        const auto v00 = hn::LoadU(d, p);
        const auto v10 = hn::LoadU(d, p + 1);
        const auto v01 = hn::LoadU(d, p + stride);
        const auto v11 = hn::LoadU(d, p + stride + 1);
        const auto fx = hn::Set(d, sample.fx);
        const auto fy = hn::Set(d, sample.fy);
        const auto dx_top = hn::Sub(v10, v00);
        const auto dx_bottom = hn::Sub(v11, v01);
        const auto top = hn::MulAdd(fx, dx_top, v00);
        const auto bottom = hn::MulAdd(fx, dx_bottom, v01);
        const auto dy = hn::Sub(bottom, top);
        const auto dx = hn::MulAdd(fy, hn::Sub(dx_bottom, dx_top), dx_top);
        const auto g = hn::MulAdd(dx, hn::Set(d, sample.dx), hn::Mul(dy, hn::Set(d, sample.dy)));
        auto value = hn::MulAdd(fy, dy, top);
        if (k == 0) origin = value;
        value = hn::Sub(value, origin);
        const auto colours = hn::LoadU(d, sample.colours + row * stride + lane);
        const auto q = hn::IfThenElseZero(hn::Eq(colours, hn::Set(d, sample.colour)),
                                          hn::Set(d, sample.weight));
        const auto qi = hn::Mul(q, value);
        const auto qg = hn::Mul(q, g);
        sum_q = hn::Add(sum_q, q);
        max_q = hn::Max(max_q, q);
        sum_i = hn::Add(sum_i, qi);
        sum_g = hn::Add(sum_g, qg);
        sum_ii = hn::MulAdd(qi, value, sum_ii);
        sum_gi = hn::MulAdd(qg, value, sum_gi);
        sum_gg = hn::MulAdd(qg, g, sum_gg);
      }
      const auto weight = hn::Mul(column_weight, hn::Set(d, kPatchWeights[row]));
      const auto inverse_q = hn::Div(hn::Set(d, 1.0f), hn::Max(sum_q, hn::Set(d, 1e-6f)));
      const auto mean_i = hn::Mul(sum_i, inverse_q);
      const auto mean_g = hn::Mul(sum_g, inverse_q);
      cost_sum = hn::MulAdd(weight, hn::NegMulAdd(mean_i, sum_i, sum_ii), cost_sum);
      gradient_sum = hn::MulAdd(weight, hn::NegMulAdd(mean_g, sum_i, sum_gi), gradient_sum);
      hessian_sum = hn::MulAdd(weight, hn::NegMulAdd(mean_g, sum_g, sum_gg), hessian_sum);
      freedom_sum = hn::MulAdd(weight, hn::Sub(sum_q, max_q), freedom_sum);
    }
    cost += hn::GetLane(hn::SumOfLanes(d, cost_sum));
    gradient += hn::GetLane(hn::SumOfLanes(d, gradient_sum));
    hessian += hn::GetLane(hn::SumOfLanes(d, hessian_sum));
    freedom += hn::GetLane(hn::SumOfLanes(d, freedom_sum));
  }
  return {cost, gradient, hessian, freedom};
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(SumPatchesImpl);

PatchSums SumPatches(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  return HWY_DYNAMIC_DISPATCH(SumPatchesImpl)(samples, count, stride);
}

PatchSums SumPatchesReference(const PatchSample* samples, int count, std::ptrdiff_t stride) {
  double cost = 0, gradient = 0, hessian = 0, freedom = 0;
  for (int row = 0; row <= 2 * kPatchRadius; ++row) {
    for (int column = 0; column <= 2 * kPatchRadius; ++column) {
      double sum_q = 0, max_q = 0, sum_i = 0, sum_g = 0, sum_ii = 0, sum_gi = 0, sum_gg = 0;
      for (int k = 0; k < count; ++k) {
        const PatchSample& s = samples[k];
        if (s.colours[row * stride + column] != s.colour) continue;
        const float* p = s.image + row * stride + column;
        const double top = p[0] + s.fx * (p[1] - p[0]);
        const double bottom = p[stride] + s.fx * (p[stride + 1] - p[stride]);
        const double dx = (1 - s.fy) * (p[1] - p[0]) + s.fy * (p[stride + 1] - p[stride]);
        const double value = top + s.fy * (bottom - top);
        const double g = dx * s.dx + (bottom - top) * s.dy;
        sum_q += s.weight;
        max_q = std::max<double>(max_q, s.weight);
        sum_i += s.weight * value;
        sum_g += s.weight * g;
        sum_ii += s.weight * value * value;
        sum_gi += s.weight * g * value;
        sum_gg += s.weight * g * g;
      }
      if (sum_q <= 0) continue;
      const double weight = kPatchWeights[row] * kPatchWeights[column];
      cost += weight * (sum_ii - sum_i * sum_i / sum_q);
      gradient += weight * (sum_gi - sum_g * sum_i / sum_q);
      hessian += weight * (sum_gg - sum_g * sum_g / sum_q);
      freedom += weight * (sum_q - max_q);
    }
  }
  return {static_cast<float>(cost),
          static_cast<float>(gradient),
          static_cast<float>(hessian),
          static_cast<float>(freedom)};
}

}  // namespace prism
#endif  // HWY_ONCE
