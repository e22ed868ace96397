// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// The derivatives of ScaledProjection in vectors, one lane a pixel, for kernels that Highway
// compiles once an instruction set.
#if defined(PRISM_FACTORS_PROJECTION_JACOBIAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PRISM_FACTORS_PROJECTION_JACOBIAN_INL_H
#undef PRISM_FACTORS_PROJECTION_JACOBIAN_INL_H
#else
#define PRISM_FACTORS_PROJECTION_JACOBIAN_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prism {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Vectors of some instruction sets cannot be members: those of three coordinates go one by one.

// ScaledProjection::PullBack: a value's derivative over X = (X, Y, Z) from its gradient in the
// image.
template <class V>
HWY_INLINE void PullBack(
    V gradient_x, V gradient_y, V alpha, V inverse_D, V X, V Y, V& over_X, V& over_Y, V& over_Z) {
  over_X = hn::Mul(gradient_x, alpha);
  over_Y = hn::Mul(gradient_y, alpha);
  over_Z = hn::Neg(hn::Mul(hn::MulAdd(over_X, X, hn::Mul(over_Y, Y)), inverse_D));
}

// ScaledProjection::OverPose: store(k, derivative) for the six of a pose, translation first.
template <class V, class Store>
HWY_INLINE void StoreOverPose(
    V over_X, V over_Y, V over_Z, V X, V Y, V Z, V rho, const Store& store) {
  store(0, hn::Mul(rho, over_X));
  store(1, hn::Mul(rho, over_Y));
  store(2, hn::Mul(rho, over_Z));
  store(3, hn::MulSub(Y, over_Z, hn::Mul(Z, over_Y)));
  store(4, hn::MulSub(Z, over_X, hn::Mul(X, over_Z)));
  store(5, hn::MulSub(X, over_Y, hn::Mul(Y, over_X)));
}

// ScaledProjection::OverInverseDepth, with (dX, dY, dZ) those of X by the inverse depth.
template <class V>
HWY_INLINE V OverInverseDepth(V over_X, V over_Y, V over_Z, V dX, V dY, V dZ, V center_z) {
  return hn::MulAdd(over_X, dX, hn::MulAdd(over_Y, dY, hn::Mul(over_Z, hn::Sub(dZ, center_z))));
}

}  // namespace HWY_NAMESPACE
}  // namespace prism
HWY_AFTER_NAMESPACE();

#endif
