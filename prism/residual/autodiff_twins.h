// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include "prism/residual/inverse_virtual_depth.h"
#include "prism/residual/photometric.h"

namespace prism {

// The residuals once more, written as the supplement prints them and templated for Ceres' automatic
// differentiation: the oracle the analytic Jacobians are held against in tests and in
// prism_check_jacobians. Nothing else uses them.

// Scalar part of a double or a ceres::Jet.
inline double ScalarPart(double value) { return value; }
template <int N>
double ScalarPart(const ceres::Jet<double, N>& value) {
  return value.a;
}

// The bilinear interpolant at a position that carries derivatives.
template <typename T>
T InterpolateWithDerivatives(const ImageViewF& image, const T& x, const T& y) {
  const int x0 = std::min(static_cast<int>(ScalarPart(x)), image.width - 2);
  const int y0 = std::min(static_cast<int>(ScalarPart(y)), image.height - 2);
  const T fx = x - T(x0);
  const T fy = y - T(y0);
  return (1.0 - fy) * ((1.0 - fx) * T(image(x0, y0)) + fx * T(image(x0 + 1, y0))) +
         fy * ((1.0 - fx) * T(image(x0, y0 + 1)) + fx * T(image(x0 + 1, y0 + 1)));
}

// x_target = R x_source + t for the 7 doubles of SE3 (quaternion x, y, z, w).
template <typename T>
void TransformPoint(const T* pose, const T* x, T* transformed) {
  const T quaternion_wxyz[4] = {pose[3], pose[0], pose[1], pose[2]};
  ceres::QuaternionRotatePoint(quaternion_wxyz, x, transformed);
  for (int i = 0; i < 3; ++i) transformed[i] += pose[4 + i];
}

template <typename T>
void InverseTransformPoint(const T* pose, const T* x, T* transformed) {
  const T conjugate_wxyz[4] = {pose[3], -pose[0], -pose[1], -pose[2]};
  const T shifted[3] = {x[0] - pose[4], x[1] - pose[5], x[2] - pose[6]};
  ceres::QuaternionRotatePoint(conjugate_wxyz, shifted, transformed);
}

struct PhotometricTwin {
  const PhotometricPatch* patch;
  ImageViewF target_image;
  const PlenopticProjection* camera;

  template <typename T>
  bool operator()(const T* host, const T* target, const T* rho, T* residuals) const {
    for (int k = 0; k < kPatternSize; ++k) {
      // Eq. (17)
      const T z = 1.0 / *rho;
      const T b_L_host = 1.0 / (1.0 / camera->f - *rho);
      const double x_V = patch->px.x() + kPattern[k][0];
      const double y_V = patch->px.y() + kPattern[k][1];
      const T x_host[3] = {z / b_L_host * (x_V - camera->c.x()) * camera->s,
                           z / b_L_host * (y_V - camera->c.y()) * camera->s,
                           z};
      T x_world[3], x_target[3];
      InverseTransformPoint(host, x_host, x_world);
      TransformPoint(target, x_world, x_target);
      // Eqs. (2), (10)
      const T b_L = 1.0 / (1.0 / camera->f - 1.0 / x_target[2]);
      const T u = x_target[0] / x_target[2] * b_L / camera->s + camera->c.x();
      const T v = x_target[1] / x_target[2] * b_L / camera->s + camera->c.y();
      // Eq. (20)
      const T gain = exp(target[7]) / exp(host[7]);
      residuals[k] = static_cast<double>(patch->weight[k]) *
                     ((InterpolateWithDerivatives(target_image, u, v) - target[8]) -
                      gain * (static_cast<double>(patch->intensity[k]) - host[8]));
    }
    return true;
  }
};

struct InverseVirtualDepthTwin {
  double w_measured;
  double sigma;
  const PlenopticProjection* camera;

  template <typename T>
  bool operator()(const T* rho, T* residual) const {
    const T b_L = 1.0 / (1.0 / camera->f - *rho);  // Eq. (2)
    const T v = (b_L - camera->b_L0) / camera->B;  // Eq. (4)
    residual[0] = (1.0 / v - w_measured) / sigma;  // Eq. (22)
    return true;
  }
};

}  // namespace prism
