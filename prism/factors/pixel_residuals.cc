// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/pixel_residuals.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prism/factors/pixel_residuals.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "prism/factors/projection_jacobian-inl.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "prism/image/patch.h"

#ifndef PRISM_FACTORS_PIXEL_RESIDUALS_BATCH
#define PRISM_FACTORS_PIXEL_RESIDUALS_BATCH
namespace prism {

// Plain numbers: what is compiled for several instruction sets must not see Eigen.
struct PixelBatch {
  const double *m_x, *m_y, *intensity, *rho;
  double R[3][3], t[3], gain, b;
  double center_z, f_px, c_x, c_y;
  ImageViewF image;
};

// A batch between the passes: what is read from memory one by one is written in one pass and read
// as vectors in another.
struct ProjectedBatch {
  alignas(64) double X[3][kPixelBatch];
  double inverse_D[kPixelBatch];
  double fx[kPixelBatch], fy[kPixelBatch];
  alignas(64) int32_t offset[kPixelBatch];  // of the pixel at the top left
  alignas(64) float top[2 * kPixelBatch];   // that pixel and the one to its right
  alignas(64) float bottom[2 * kPixelBatch];
};

}  // namespace prism
#endif

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The position of each pixel in the target image; what is not seen is put into the image's corner.
void Project(const PixelBatch& batch, ProjectedBatch* projected, double* seen_of) {
  const hn::CappedTag<double, 8> d;
  const hn::Rebind<int32_t, decltype(d)> di;
  const auto set = [&](double value) { return hn::Set(d, value); };
  const auto one = set(1);
  const auto row = [&](int i, auto a, auto b, auto rho) {
    const auto shifted = hn::MulAdd(rho, set(batch.t[i]), set(batch.R[i][2]));
    return hn::MulAdd(set(batch.R[i][0]), a, hn::MulAdd(set(batch.R[i][1]), b, shifted));
  };
  const auto max_x = set(batch.image.width - 2), max_y = set(batch.image.height - 2);
  const auto stride = hn::Set(di, static_cast<int32_t>(batch.image.stride));
  for (size_t i = 0; i < kPixelBatch; i += hn::Lanes(d)) {
    const auto rho = hn::LoadU(d, batch.rho + i);
    const auto rho_center = hn::Mul(rho, set(batch.center_z));
    const auto k = hn::Sub(one, rho_center);
    const auto a = hn::Mul(hn::LoadU(d, batch.m_x + i), k);
    const auto b = hn::Mul(hn::LoadU(d, batch.m_y + i), k);
    const auto X = row(0, a, b, rho), Y = row(1, a, b, rho), Z = row(2, a, b, rho);
    const auto D = hn::Sub(Z, rho_center);
    const auto inverse_D = hn::Div(one, D);
    const auto alpha = hn::Mul(set(batch.f_px), inverse_D);
    const auto x = hn::MulAdd(alpha, X, set(batch.c_x));
    const auto y = hn::MulAdd(alpha, Y, set(batch.c_y));
    const auto inside_x = hn::And(hn::Ge(x, one), hn::Le(x, max_x));
    const auto inside_y = hn::And(hn::Ge(y, one), hn::Le(y, max_y));
    const auto seen = hn::And(hn::Gt(D, hn::Zero(d)), hn::And(inside_x, inside_y));
    const auto x_safe = hn::IfThenElseZero(seen, x);
    const auto y_safe = hn::IfThenElseZero(seen, y);
    const auto x0 = hn::DemoteTo(di, x_safe);
    const auto y0 = hn::DemoteTo(di, y_safe);
    hn::Store(hn::Sub(x_safe, hn::PromoteTo(d, x0)), d, projected->fx + i);
    hn::Store(hn::Sub(y_safe, hn::PromoteTo(d, y0)), d, projected->fy + i);
    hn::Store(hn::Add(hn::Mul(y0, stride), x0), di, projected->offset + i);
    hn::Store(hn::IfThenElseZero(seen, X), d, projected->X[0] + i);
    hn::Store(hn::IfThenElseZero(seen, Y), d, projected->X[1] + i);
    hn::Store(hn::IfThenElseZero(seen, Z), d, projected->X[2] + i);
    hn::Store(hn::IfThenElseZero(seen, inverse_D), d, projected->inverse_D + i);
    hn::Store(hn::IfThenElseZero(seen, one), d, seen_of + i);
  }
}

void ReadImage(const ImageViewF& image, ProjectedBatch* projected) {
  for (int i = 0; i < kPixelBatch; ++i) {
    const float* const pixel = image.data + projected->offset[i];
    std::memcpy(projected->top + 2 * i, pixel, 2 * sizeof(float));
    std::memcpy(projected->bottom + 2 * i, pixel + image.stride, 2 * sizeof(float));
  }
}

void Compare(const PixelBatch& batch,
             const ProjectedBatch& projected,
             bool with_jacobians,
             PixelResiduals* residuals) {
  const hn::CappedTag<double, 8> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto set = [&](double value) { return hn::Set(d, value); };
  for (size_t i = 0; i < kPixelBatch; i += hn::Lanes(d)) {
    hn::Vec<decltype(df)> v00, v10, v01, v11;
    hn::LoadInterleaved2(df, projected.top + 2 * i, v00, v10);
    hn::LoadInterleaved2(df, projected.bottom + 2 * i, v01, v11);
    const auto left_top = hn::PromoteTo(d, v00), left_bottom = hn::PromoteTo(d, v01);
    const auto dx_top = hn::Sub(hn::PromoteTo(d, v10), left_top);
    const auto dx_bottom = hn::Sub(hn::PromoteTo(d, v11), left_bottom);
    const auto fx = hn::Load(d, projected.fx + i), fy = hn::Load(d, projected.fy + i);
    const auto top = hn::MulAdd(fx, dx_top, left_top);
    const auto dy = hn::Sub(hn::MulAdd(fx, dx_bottom, left_bottom), top);
    const auto value = hn::MulAdd(fy, dy, top);
    const auto scaled = hn::Mul(set(batch.gain), hn::LoadU(d, batch.intensity + i));
    const auto expected = hn::Add(scaled, set(batch.b));
    const auto clipped = hn::And(hn::Ge(value, set(kWhite)), hn::Gt(expected, set(kBrightest)));
    const auto projects = hn::Gt(hn::Load(d, residuals->seen + i), hn::Zero(d));
    const auto seen = hn::AndNot(clipped, projects);
    hn::Store(hn::IfThenElseZero(seen, set(1)), d, residuals->seen + i);
    hn::Store(hn::IfThenElseZero(seen, hn::Sub(value, expected)), d, residuals->rows[8] + i);
    if (!with_jacobians) continue;

    const auto X = hn::Load(d, projected.X[0] + i);
    const auto Y = hn::Load(d, projected.X[1] + i);
    const auto Z = hn::Load(d, projected.X[2] + i);
    const auto inverse_D = hn::Load(d, projected.inverse_D + i);
    const auto alpha = hn::IfThenElseZero(seen, hn::Mul(set(batch.f_px), inverse_D));
    const auto dx = hn::MulAdd(fy, hn::Sub(dx_bottom, dx_top), dx_top);
    hn::Vec<decltype(d)> over_X, over_Y, over_Z;
    PullBack(dx, dy, alpha, inverse_D, X, Y, over_X, over_Y, over_Z);
    const auto rho = hn::IfThenElseZero(seen, hn::LoadU(d, batch.rho + i));
    const auto store = [&](int k, auto J) { hn::Store(J, d, residuals->rows[k] + i); };
    StoreOverPose(over_X, over_Y, over_Z, X, Y, Z, rho, store);
    store(6, hn::Neg(scaled));
    store(7, set(-1));
    // The pixel is held: dX / drho = t - center_z R [m; 0].
    const auto m_x = hn::IfThenElseZero(seen, hn::LoadU(d, batch.m_x + i));
    const auto m_y = hn::IfThenElseZero(seen, hn::LoadU(d, batch.m_y + i));
    const auto dX_drho = [&](int k) {
      const auto from_y = hn::NegMulAdd(set(batch.center_z * batch.R[k][1]), m_y, set(batch.t[k]));
      return hn::NegMulAdd(set(batch.center_z * batch.R[k][0]), m_x, from_y);
    };
    const auto J_rho = OverInverseDepth(
        over_X, over_Y, over_Z, dX_drho(0), dX_drho(1), dX_drho(2), set(batch.center_z));
    hn::Store(J_rho, d, residuals->J_rho + i);
  }
}

void EvaluatePixelsImpl(const PixelBatch& batch, bool with_jacobians, PixelResiduals* residuals) {
  ProjectedBatch projected;
  Project(batch, &projected, residuals->seen);
  ReadImage(batch.image, &projected);
  Compare(batch, projected, with_jacobians, residuals);
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prism {

HWY_EXPORT(EvaluatePixelsImpl);

ReferencePixels::ReferencePixels(size_t size) {
  const size_t padded = (size + kPixelBatch - 1) / kPixelBatch * kPixelBatch;
  m_x_.assign(padded, std::numeric_limits<double>::quiet_NaN());
  m_y_.assign(padded, 0);
  intensity_.assign(padded, 0);
  weight_.assign(padded, 0);
}

void ReferencePixels::Set(size_t i, const ReferencePixel& pixel) {
  m_x_[i] = pixel.m.x();
  m_y_[i] = pixel.m.y();
  intensity_[i] = pixel.intensity;
  weight_[i] = pixel.weight;
}

bool ReferencePixels::Holds(size_t i) const { return !std::isnan(m_x_[i]); }

void EvaluatePixels(const ReferencePixels& pixels,
                    size_t first,
                    const double* rho,
                    const RelativeState& state,
                    const PlenopticProjection& camera,
                    const ImageViewF& target_image,
                    bool with_jacobians,
                    PixelResiduals* residuals) {
  PixelBatch batch = {pixels.m_x() + first,
                      pixels.m_y() + first,
                      pixels.intensity() + first,
                      rho,
                      {},
                      {},
                      state.gain,
                      state.b,
                      camera.center_z(),
                      camera.FocalLengthPx(),
                      camera.c.x(),
                      camera.c.y(),
                      target_image};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) batch.R[i][k] = state.target_from_reference.R(i, k);
    batch.t[i] = state.target_from_reference.t[i];
  }
  HWY_DYNAMIC_DISPATCH(EvaluatePixelsImpl)(batch, with_jacobians, residuals);
}

}  // namespace prism
#endif  // HWY_ONCE
