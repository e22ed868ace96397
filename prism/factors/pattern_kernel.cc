// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/pattern_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/factors/pattern_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "prism/factors/projection_jacobian-inl.h"

#include <cstdint>
#include <cstring>

#ifndef PRISM_FACTORS_PATTERN_OFFSETS
#define PRISM_FACTORS_PATTERN_OFFSETS
namespace prism {

// kPattern by coordinate.
struct PatternOffsets {
  alignas(64) double dx[kPatternSize] = {};
  alignas(64) double dy[kPatternSize] = {};
};

constexpr PatternOffsets MakeOffsets() {
  PatternOffsets offsets;
  for (int k = 0; k < kPatternSize; ++k) {
    offsets.dx[k] = kPattern[k][0];
    offsets.dy[k] = kPattern[k][1];
  }
  return offsets;
}
inline constexpr PatternOffsets kOffsets = MakeOffsets();

}  // namespace prism
#endif

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kPatternSize>;

// One coordinate of center + dx step_x + dy step_y.
template <class D>
HWY_INLINE hn::Vec<D> Coordinate(D d, const PatternGeometry& geometry, int i, size_t lane) {
  const auto dx = hn::Load(d, kOffsets.dx + lane), dy = hn::Load(d, kOffsets.dy + lane);
  return hn::MulAdd(dx,
                    hn::Set(d, geometry.step_x[i]),
                    hn::MulAdd(dy, hn::Set(d, geometry.step_y[i]), hn::Set(d, geometry.center[i])));
}

bool SamplePatternImpl(const PatternGeometry& geometry,
                       const PatternBrightness& brightness,
                       const ImageViewF& image,
                       PatternSamples* samples) {
  const Doubles d;
  const hn::Rebind<int32_t, Doubles> di;
  const hn::Rebind<float, Doubles> df;
  const auto set = [&](double value) { return hn::Set(d, value); };
  alignas(64) double fx_of[kPatternSize], fy_of[kPatternSize];
  alignas(64) int32_t offset[kPatternSize];
  for (size_t i = 0; i < kPatternSize; i += hn::Lanes(d)) {
    const auto D = hn::Sub(Coordinate(d, geometry, 2, i), set(geometry.rho * geometry.center_z));
    const auto alpha = hn::Div(set(geometry.f_px), D);
    const auto x = hn::MulAdd(alpha, Coordinate(d, geometry, 0, i), set(geometry.c_x));
    const auto y = hn::MulAdd(alpha, Coordinate(d, geometry, 1, i), set(geometry.c_y));
    const auto from_left = hn::And(hn::Ge(x, hn::Zero(d)), hn::Le(x, set(image.width - 1)));
    const auto from_top = hn::And(hn::Ge(y, hn::Zero(d)), hn::Le(y, set(image.height - 1)));
    const auto in_front = hn::Gt(D, hn::Zero(d));
    if (!hn::AllTrue(d, hn::And(in_front, hn::And(from_left, from_top)))) return false;
    const auto x0 = hn::Min(hn::DemoteTo(di, x), hn::Set(di, image.width - 2));
    const auto y0 = hn::Min(hn::DemoteTo(di, y), hn::Set(di, image.height - 2));
    hn::Store(hn::Sub(x, hn::PromoteTo(d, x0)), d, fx_of + i);
    hn::Store(hn::Sub(y, hn::PromoteTo(d, y0)), d, fy_of + i);
    const auto stride = hn::Set(di, static_cast<int32_t>(image.stride));
    hn::Store(hn::Add(hn::Mul(y0, stride), x0), di, offset + i);
  }
  // The pixel at the top left and the one to its right, and those below.
  alignas(64) float above[2 * kPatternSize], below[2 * kPatternSize];
  for (int k = 0; k < kPatternSize; ++k) {
    const float* const pixel = image.data + offset[k];
    std::memcpy(above + 2 * k, pixel, 2 * sizeof(float));
    std::memcpy(below + 2 * k, pixel + image.stride, 2 * sizeof(float));
  }
  for (size_t i = 0; i < kPatternSize; i += hn::Lanes(d)) {
    hn::Vec<decltype(df)> v00, v10, v01, v11;
    hn::LoadInterleaved2(df, above + 2 * i, v00, v10);
    hn::LoadInterleaved2(df, below + 2 * i, v01, v11);
    const auto left_top = hn::PromoteTo(d, v00), left_bottom = hn::PromoteTo(d, v01);
    const auto dx_top = hn::Sub(hn::PromoteTo(d, v10), left_top);
    const auto dx_bottom = hn::Sub(hn::PromoteTo(d, v11), left_bottom);
    const auto fx = hn::Load(d, fx_of + i), fy = hn::Load(d, fy_of + i);
    const auto top = hn::MulAdd(fx, dx_top, left_top);
    const auto dy = hn::Sub(hn::MulAdd(fx, dx_bottom, left_bottom), top);
    const auto value = hn::MulAdd(fy, dy, top);
    const auto dx = hn::MulAdd(fy, hn::Sub(dx_bottom, dx_top), dx_top);
    const auto intensity = hn::PromoteTo(d, hn::LoadU(df, brightness.intensity + i));
    const auto weight = hn::Mul(hn::PromoteTo(d, hn::LoadU(df, brightness.weight + i)),
                                set(brightness.inverse_sigma));
    const auto expected =
        hn::Mul(hn::Mul(weight, set(brightness.gain)), hn::Sub(intensity, set(brightness.host_b)));
    const auto residual = hn::MulSub(weight, hn::Sub(value, set(brightness.target_b)), expected);
    hn::Store(weight, d, samples->weight + i);
    hn::Store(hn::Mul(weight, dx), d, samples->gradient_x + i);
    hn::Store(hn::Mul(weight, dy), d, samples->gradient_y + i);
    hn::Store(expected, d, samples->brightness + i);
    hn::Store(residual, d, samples->residuals + i);
  }
  return true;
}

void DifferentiatePatternImpl(const PatternGeometry& geometry,
                              const PatternGeometry& d_geometry,
                              const PatternSamples& samples,
                              PatternDerivatives* derivatives) {
  const Doubles d;
  const auto set = [&](double value) { return hn::Set(d, value); };
  const auto rho = set(geometry.rho);
  for (size_t i = 0; i < kPatternSize; i += hn::Lanes(d)) {
    const auto X = Coordinate(d, geometry, 0, i);
    const auto Y = Coordinate(d, geometry, 1, i);
    const auto Z = Coordinate(d, geometry, 2, i);
    const auto inverse_D = hn::Div(set(1), hn::Sub(Z, set(geometry.rho * geometry.center_z)));
    const auto alpha = hn::Mul(set(geometry.f_px), inverse_D);
    const auto gradient_x = hn::Load(d, samples.gradient_x + i);
    const auto gradient_y = hn::Load(d, samples.gradient_y + i);
    hn::Vec<Doubles> over_X, over_Y, over_Z;
    PullBack(gradient_x, gradient_y, alpha, inverse_D, X, Y, over_X, over_Y, over_Z);
    const auto store = [&](int k, auto J) { hn::Store(J, d, derivatives->pose[k] + i); };
    StoreOverPose(over_X, over_Y, over_Z, X, Y, Z, rho, store);
    const auto J_rho = OverInverseDepth(over_X,
                                        over_Y,
                                        over_Z,
                                        Coordinate(d, d_geometry, 0, i),
                                        Coordinate(d, d_geometry, 1, i),
                                        Coordinate(d, d_geometry, 2, i),
                                        set(geometry.center_z));
    hn::Store(J_rho, d, derivatives->rho + i);
  }
}

void MovePatternImpl(const PatternDerivatives& target,
                     const double* adjoint,
                     PatternDerivatives* host) {
  const Doubles d;
  for (size_t i = 0; i < kPatternSize; i += hn::Lanes(d)) {
    for (int column = 0; column < 6; ++column) {
      auto sum = hn::Zero(d);
      for (int row = 0; row < 6; ++row) {
        sum = hn::NegMulAdd(
            hn::Set(d, adjoint[6 * column + row]), hn::Load(d, target.pose[row] + i), sum);
      }
      hn::Store(sum, d, host->pose[column] + i);
    }
  }
}

void LiftPatternImpl(const PatternDerivatives& derivatives,
                     const double* lift,
                     const double* J_a,
                     const double* J_b,
                     double* jacobian) {
  const hn::CappedTag<double, 4> d;
  for (int k = 0; k < kPatternSize; ++k, jacobian += 9) {
    for (size_t i = 0; i < 4; i += hn::Lanes(d)) {
      auto sum = hn::Zero(d);
      for (int row = 0; row < 6; ++row) {
        sum =
            hn::MulAdd(hn::Set(d, derivatives.pose[row][k]), hn::LoadU(d, lift + 7 * row + i), sum);
      }
      hn::StoreU(sum, d, jacobian + i);
    }
    for (int i = 0; i < 3; ++i) jacobian[4 + i] = derivatives.pose[i][k];
    jacobian[7] = J_a[k];
    jacobian[8] = J_b[k];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(SamplePatternImpl);
HWY_EXPORT(DifferentiatePatternImpl);
HWY_EXPORT(MovePatternImpl);
HWY_EXPORT(LiftPatternImpl);

bool SamplePattern(const PatternGeometry& geometry,
                   const PatternBrightness& brightness,
                   const ImageViewF& target_image,
                   PatternSamples* samples) {
  return HWY_DYNAMIC_DISPATCH(SamplePatternImpl)(geometry, brightness, target_image, samples);
}

void DifferentiatePattern(const PatternGeometry& geometry,
                          const PatternGeometry& d_geometry,
                          const PatternSamples& samples,
                          PatternDerivatives* derivatives) {
  HWY_DYNAMIC_DISPATCH(DifferentiatePatternImpl)(geometry, d_geometry, samples, derivatives);
}

void MovePattern(const PatternDerivatives& target,
                 const double* adjoint,
                 PatternDerivatives* host) {
  HWY_DYNAMIC_DISPATCH(MovePatternImpl)(target, adjoint, host);
}

void LiftPattern(const PatternDerivatives& derivatives,
                 const double* lift,
                 const double* J_a,
                 const double* J_b,
                 double* jacobian) {
  HWY_DYNAMIC_DISPATCH(LiftPatternImpl)(derivatives, lift, J_a, J_b, jacobian);
}

}  // namespace prism
#endif  // HWY_ONCE
