// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_kernel.h"

#include <array>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/io/rgbd_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PRISM_RGBD_KERNEL_ONCE
#define PRISM_RGBD_KERNEL_ONCE
namespace prism {

constexpr int kFractionBits = 5;  // of a position, px
using CubicWeights = std::array<std::array<float, 4>, 1 << kFractionBits>;

inline CubicWeights MakeCubicWeights() {
  constexpr float a = -0.75f;
  CubicWeights weights;
  for (size_t i = 0; i < weights.size(); ++i) {
    const float x = static_cast<float>(i) / static_cast<float>(weights.size());
    const auto inner = [](float t) { return ((a + 2) * t - (a + 3)) * t * t + 1; };
    const float before = ((a * (x + 1) - 5 * a) * (x + 1) + 8 * a) * (x + 1) - 4 * a;
    weights[i] = {before, inner(x), inner(1 - x), 1 - before - inner(x) - inner(1 - x)};
  }
  return weights;
}

}  // namespace prism
#endif

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kRgbdRowPadding>;
using Ints = hn::RebindToSigned<Floats>;
using FloatVector = hn::Vec<Floats>;
using IntVector = hn::Vec<Ints>;

// Clamps to [0, size - 1].
HWY_INLINE IntVector InImage(IntVector index, int size) {
  const Ints d;
  return hn::Min(hn::Max(index, hn::Zero(d)), hn::Set(d, size - 1));
}

HWY_INLINE IntVector IndexOf(const ImageViewF& image, IntVector x, IntVector y) {
  return hn::Add(hn::Mul(y, hn::Set(Ints(), static_cast<int>(image.stride))), x);
}

void FindPinholePositionsImpl(
    const PlenopticProjection& camera, const ImageViewF& filled, int y, float* px, float* py) {
  const Floats d;
  const Ints di;
  const float cx = static_cast<float>(camera.c.x()), cy = static_cast<float>(camera.c.y());
  const auto full_scale = hn::Set(d, static_cast<float>((2 * camera.B + camera.b_L0) / camera.f));
  const auto f = hn::Set(d, static_cast<float>(camera.f));
  const auto half = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f);
  const auto dy = hn::Set(d, static_cast<float>(y) - cy);
  for (int x = 0; x < filled.width; x += static_cast<int>(hn::Lanes(d))) {
    const auto dx = hn::Sub(hn::Iota(d, static_cast<float>(x)), hn::Set(d, cx));
    auto rho = hn::LoadU(d, filled.row(y) + x);
    for (int iteration = 0;; ++iteration) {
      const auto scale = hn::Mul(full_scale, hn::NegMulAdd(rho, f, one));
      const auto at_x = hn::MulAdd(scale, dx, hn::Set(d, cx));
      const auto at_y = hn::MulAdd(scale, dy, hn::Set(d, cy));
      if (iteration == 2) {
        hn::StoreU(at_x, d, px + x);
        hn::StoreU(at_y, d, py + x);
        break;
      }
      const auto column = InImage(hn::ConvertTo(di, hn::Add(at_x, half)), filled.width);
      const auto row = InImage(hn::ConvertTo(di, hn::Add(at_y, half)), filled.height);
      rho = hn::GatherIndex(d, filled.data, IndexOf(filled, column, row));
    }
  }
}

// 1/z at positions, see MeasureInverseVirtualDepth.
HWY_INLINE FloatVector InterpolateInverseDepth(const ImageViewF& image,
                                               float edge_ratio,
                                               FloatVector x,
                                               FloatVector y) {
  const Floats d;
  const Ints di;
  const auto left = hn::Floor(x), top = hn::Floor(y);
  const auto is_inside =
      hn::And(hn::Ge(hn::Min(left, top), hn::Zero(d)),
              hn::And(hn::Lt(left, hn::Set(d, static_cast<float>(image.width - 1))),
                      hn::Lt(top, hn::Set(d, static_cast<float>(image.height - 1)))));
  const auto index = IndexOf(image,
                             hn::ConvertTo(di, hn::IfThenElseZero(is_inside, left)),
                             hn::ConvertTo(di, hn::IfThenElseZero(is_inside, top)));
  const float* below = image.row(1);
  const auto v00 = hn::GatherIndex(d, image.data, index);
  const auto v10 = hn::GatherIndex(d, image.data + 1, index);
  const auto v01 = hn::GatherIndex(d, below, index);
  const auto v11 = hn::GatherIndex(d, below + 1, index);
  const auto low = hn::Min(hn::Min(v00, v10), hn::Min(v01, v11));
  const auto high = hn::Max(hn::Max(v00, v10), hn::Max(v01, v11));
  const auto fx = hn::Sub(x, left), fy = hn::Sub(y, top);
  const auto at_top = hn::MulAdd(fx, hn::Sub(v10, v00), v00);
  const auto at_bottom = hn::MulAdd(fx, hn::Sub(v11, v01), v01);
  const auto smooth = hn::MulAdd(fy, hn::Sub(at_bottom, at_top), at_top);
  const auto is_left = hn::Lt(fx, hn::Set(d, 0.5f)), is_top = hn::Lt(fy, hn::Set(d, 0.5f));
  const auto nearest =
      hn::IfThenElse(is_top, hn::IfThenElse(is_left, v00, v10), hn::IfThenElse(is_left, v01, v11));
  const auto is_edge = hn::Or(hn::Eq(low, hn::Zero(d)),
                              hn::Gt(hn::Sub(high, low), hn::Mul(hn::Set(d, edge_ratio), high)));
  return hn::IfThenElseZero(is_inside, hn::IfThenElse(is_edge, nearest, smooth));
}

void MeasureInverseVirtualDepthImpl(const PlenopticProjection& camera,
                                    const ImageViewF& inverse_depth,
                                    float edge_ratio,
                                    const float* px,
                                    const float* py,
                                    const float* noise,
                                    float sigma,
                                    float* inverse_virtual_depth) {
  const Floats d;
  const auto set = [&](double value) { return hn::Set(d, static_cast<float>(value)); };
  const auto f = set(camera.f), B = set(camera.B), f_b_L0 = set(camera.f * camera.b_L0);
  const auto f_minus_b_L0 = set(camera.f - camera.b_L0);
  for (int x = 0; x < inverse_depth.width; x += static_cast<int>(hn::Lanes(d))) {
    const auto rho = InterpolateInverseDepth(
        inverse_depth, edge_ratio, hn::LoadU(d, px + x), hn::LoadU(d, py + x));
    // Eq. (86), see InverseVirtualDepth.
    const auto clean =
        hn::Div(hn::Mul(B, hn::NegMulAdd(rho, f, set(1))), hn::MulAdd(rho, f_b_L0, f_minus_b_L0));
    const auto w = hn::MulAdd(set(sigma), hn::LoadU(d, noise + x), clean);
    const auto is_measured =
        hn::And(hn::Ne(rho, hn::Zero(d)), hn::And(hn::Gt(w, hn::Zero(d)), hn::Le(w, set(0.5))));
    hn::StoreU(hn::IfThenElseZero(is_measured, w), d, inverse_virtual_depth + x);
  }
}

// Positions of a run of pixels, split.
struct SplitPositions {
  HWY_ALIGN int32_t first[kRgbdRowPadding];  // of the 4 x 4 pixels, from the image's first
  HWY_ALIGN int32_t fraction_x[kRgbdRowPadding];
  HWY_ALIGN int32_t fraction_y[kRgbdRowPadding];
};

HWY_INLINE void Split(const ImageViewF& image,
                      FloatVector x,
                      FloatVector y,
                      SplitPositions* split) {
  const Floats d;
  const Ints di;
  const auto fixed_point = [&](FloatVector position, int size) {
    const auto near =
        hn::Min(hn::Max(position, hn::Set(d, -2.0f)), hn::Set(d, static_cast<float>(size + 1)));
    return hn::NearestInt(hn::Mul(near, hn::Set(d, static_cast<float>(1 << kFractionBits))));
  };
  const auto fixed_x = fixed_point(x, image.width), fixed_y = fixed_point(y, image.height);
  const auto mask = hn::Set(di, (1 << kFractionBits) - 1), one = hn::Set(di, 1);
  const auto column = hn::Sub(hn::ShiftRight<kFractionBits>(fixed_x), one);
  const auto row = hn::Sub(hn::ShiftRight<kFractionBits>(fixed_y), one);
  hn::Store(IndexOf(image, column, row), di, split->first);
  hn::Store(hn::And(fixed_x, mask), di, split->fraction_x);
  hn::Store(hn::And(fixed_y, mask), di, split->fraction_y);
}

// The four columns at once where the processor can.
HWY_INLINE float Cubic(const float* first,
                       std::ptrdiff_t stride,
                       const float* wx,
                       const float* wy) {
  const hn::CappedTag<float, 4> d;
  float sum = 0;
  for (size_t c = 0; c < 4; c += hn::Lanes(d)) {
    auto columns = hn::Mul(hn::LoadU(d, first + c), hn::Set(d, wy[0]));
    for (int i = 1; i < 4; ++i) {
      columns = hn::MulAdd(hn::LoadU(d, first + i * stride + c), hn::Set(d, wy[i]), columns);
    }
    sum += hn::GetLane(hn::SumOfLanes(d, hn::Mul(columns, hn::LoadU(d, wx + c))));
  }
  return sum;
}

void ResampleRowImpl(const ImageViewF& image, const float* px, const float* py, float* values) {
  static const CubicWeights weights = MakeCubicWeights();
  const Floats d;
  constexpr int kRun = static_cast<int>(hn::MaxLanes(Floats()));
  SplitPositions split;
  for (int x = 0; x < image.width; x += kRun) {
    Split(image, hn::LoadU(d, px + x), hn::LoadU(d, py + x), &split);
    for (int i = 0; i < kRun; ++i) {
      values[x + i] = Cubic(image.data + split.first[i],
                            image.stride,
                            weights[static_cast<size_t>(split.fraction_x[i])].data(),
                            weights[static_cast<size_t>(split.fraction_y[i])].data());
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(FindPinholePositionsImpl);
HWY_EXPORT(MeasureInverseVirtualDepthImpl);
HWY_EXPORT(ResampleRowImpl);

void FindPinholePositions(
    const PlenopticProjection& camera, const ImageViewF& filled, int y, float* px, float* py) {
  HWY_DYNAMIC_DISPATCH(FindPinholePositionsImpl)(camera, filled, y, px, py);
}

void MeasureInverseVirtualDepth(const PlenopticProjection& camera,
                                const ImageViewF& inverse_depth,
                                float edge_ratio,
                                const float* px,
                                const float* py,
                                const float* noise,
                                float sigma,
                                float* inverse_virtual_depth) {
  HWY_DYNAMIC_DISPATCH(MeasureInverseVirtualDepthImpl)
  (camera, inverse_depth, edge_ratio, px, py, noise, sigma, inverse_virtual_depth);
}

void ResampleRow(const ImageViewF& image, const float* px, const float* py, float* values) {
  HWY_DYNAMIC_DISPATCH(ResampleRowImpl)(image, px, py, values);
}

}  // namespace prism
#endif  // HWY_ONCE
