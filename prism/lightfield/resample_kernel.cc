// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/resample_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/lightfield/resample_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The pixels (x0, y0), (x0 + 1, y0), ... of every lane and the colour of the first, from as many
// loads as there are rows if they lie near enough to each other, as those of a run do where depth
// is smooth: gathers take some four times as long. Lanes that are not `seen` get any values.
template <class D, class VI, class M, class V = hn::Vec<D>>
HWY_INLINE void LoadNeighbours(D d,
                               const ImageF& raw,
                               const Image<uint8_t>& colours,
                               VI x0,
                               VI y0,
                               M seen,
                               V& v00,
                               V& v10,
                               V& v01,
                               V& v11,
                               VI& colour) {
  const hn::RebindToSigned<D> di;
  constexpr int kLanes = hn::MaxLanes(D());
  const int first_x =
      hn::GetLane(hn::MinOfLanes(di, hn::IfThenElse(seen, x0, hn::Set(di, 1 << 20))));
  const int first_y =
      hn::GetLane(hn::MinOfLanes(di, hn::IfThenElse(seen, y0, hn::Set(di, 1 << 20))));
  const auto column = hn::Sub(x0, hn::Set(di, first_x));
  const auto is_near =
      hn::And(hn::Lt(column, hn::Set(di, kLanes - 1)), hn::Eq(y0, hn::Set(di, first_y)));
  if (hn::AllTrue(di, hn::Or(is_near, hn::Not(seen))) && first_x + kLanes <= raw.width()) {
    const auto here = hn::IfThenElseZero(is_near, column);
    const auto at = hn::IndicesFromVec(d, here);
    const auto right = hn::IndicesFromVec(d, hn::Add(here, hn::Set(di, 1)));
    const auto top = hn::LoadU(d, raw.row(first_y) + first_x);
    const auto bottom = hn::LoadU(d, raw.row(first_y + 1) + first_x);
    v00 = hn::TableLookupLanes(top, at);
    v10 = hn::TableLookupLanes(top, right);
    v01 = hn::TableLookupLanes(bottom, at);
    v11 = hn::TableLookupLanes(bottom, right);
    const auto bytes = hn::LoadU(hn::Rebind<uint8_t, D>(), colours.row(first_y) + first_x);
    colour = hn::TableLookupLanes(hn::PromoteTo(di, bytes), hn::IndicesFromVec(di, here));
    return;
  }
  const auto index = hn::Add(hn::Mul(y0, hn::Set(di, raw.width())), x0);
  const float* below = raw.data() + raw.width();
  v00 = hn::GatherIndex(d, raw.data(), index);
  v10 = hn::GatherIndex(d, raw.data() + 1, index);
  v01 = hn::GatherIndex(d, below, index);
  v11 = hn::GatherIndex(d, below + 1, index);
  HWY_ALIGN int32_t at[kLanes], found[kLanes];
  hn::Store(index, di, at);
  for (size_t i = 0; i < hn::Lanes(d); ++i) found[i] = colours.data()[at[i]];
  colour = hn::Load(di, found);
}

void ResampleLensImpl(const Lens& lens,
                      const ImageF& raw,
                      const Image<uint8_t>& colours,
                      float radius_px,
                      const VirtualPointRun& run,
                      const float* sharpness,
                      float* sum,
                      float* weight) {
  const hn::CappedTag<float, kResampleLanes> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto set = [&](float value) { return hn::Set(d, value); };
  const auto one = set(1.0f);
  constexpr float kMargin = 1.01f;
  for (size_t lane = 0; lane < kResampleLanes; lane += hn::Lanes(d)) {
    const auto w = hn::Load(d, run.w + lane);
    const auto ex = hn::Sub(hn::Load(d, run.X + lane), set(lens.lens_x));
    const auto ey = hn::Sub(hn::Load(d, run.Y + lane), set(lens.lens_y));
    const auto mx = hn::MulAdd(ex, w, set(lens.lens_x - lens.center_x));
    const auto my = hn::MulAdd(ey, w, set(lens.lens_y - lens.center_y));
    const auto squared = hn::MulAdd(mx, mx, hn::Mul(my, my));
    const auto x = hn::MulAdd(set(lens.axx), mx, hn::MulAdd(set(lens.axy), my, set(lens.image_x)));
    const auto y = hn::MulAdd(set(lens.ayx), mx, hn::MulAdd(set(lens.ayy), my, set(lens.image_y)));
    const auto lowest = hn::Min(x, y);
    const auto inside_x = hn::Le(x, set(static_cast<float>(raw.width()) - 1 - kMargin));
    const auto inside_y = hn::Le(y, set(static_cast<float>(raw.height()) - 1 - kMargin));
    const auto seen = hn::And(hn::And(hn::Le(squared, set(radius_px * radius_px)), inside_x),
                              hn::And(inside_y, hn::Ge(lowest, set(kMargin))));
    if (hn::AllFalse(d, seen)) continue;
    const auto x_safe = hn::IfThenElseZero(seen, x);
    const auto y_safe = hn::IfThenElseZero(seen, y);
    const auto x0 = hn::ConvertTo(di, x_safe);
    const auto y0 = hn::ConvertTo(di, y_safe);
    const auto fx = hn::Sub(x_safe, hn::ConvertTo(d, x0));
    const auto fy = hn::Sub(y_safe, hn::ConvertTo(d, y0));
    hn::Vec<decltype(d)> v00, v10, v01, v11;
    hn::Vec<decltype(di)> colour;
    LoadNeighbours(d, raw, colours, x0, y0, hn::RebindMask(di, seen), v00, v10, v01, v11, colour);
    const auto top = hn::MulAdd(fx, hn::Sub(v10, v00), v00);
    const auto bottom = hn::MulAdd(fx, hn::Sub(v11, v01), v01);
    const auto value = hn::MulAdd(fy, hn::Sub(bottom, top), top);
    const auto good = hn::RebindMask(d, hn::Eq(colour, hn::Set(di, lens.colour + 1)));
    const auto inner = hn::NegMulAdd(squared, set(1 / (radius_px * radius_px)), set(1.001f));
    auto q = hn::Mul(hn::Mul(inner, inner), hn::Load(d, sharpness + lane));
    q = hn::Mul(q, hn::IfThenElse(good, one, set(1e-3f)));
    q = hn::IfThenElseZero(seen, q);
    hn::Store(hn::MulAdd(q, value, hn::Load(d, sum + lane)), d, sum + lane);
    hn::Store(hn::Add(q, hn::Load(d, weight + lane)), d, weight + lane);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(ResampleLensImpl);

void ResampleLens(const Lens& lens,
                  const ImageF& raw,
                  const Image<uint8_t>& colours,
                  float radius_px,
                  const VirtualPointRun& run,
                  const float* sharpness,
                  float* sum,
                  float* weight) {
  HWY_DYNAMIC_DISPATCH(ResampleLensImpl)
  (lens, raw, colours, radius_px, run, sharpness, sum, weight);
}

}  // namespace prism
#endif  // HWY_ONCE
