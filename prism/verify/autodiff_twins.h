// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include "prism/camera/projection.h"
#include "prism/factors/pixel_residuals.h"
#include "prism/image/image.h"
#include "prism/image/patch.h"

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

// From the main lens to the plane on which the chief ray of a point meets its pixel: that of its
// virtual image (Eq. (2)), or in images of chief rays that of infinitely far points.
template <typename T>
T ImageDistanceTwin(const PlenopticProjection& camera, const T& rho) {
  if (camera.image == FocusedImage::kChiefRays) return T(camera.f);
  return 1.0 / (1.0 / camera.f - rho);
}

// Eqs. (17), (15), (2), (10): a host pixel at a depth to the target's pixel (u, v).
// `target_from_host` maps a point; it stands for two poses or one.
template <typename T, typename Transform>
void ProjectTwin(const PlenopticProjection& camera,
                 double x_V,
                 double y_V,
                 const T& rho,
                 const Transform& target_from_host,
                 T* u,
                 T* v) {
  const T z = 1.0 / rho;
  const T b_host = ImageDistanceTwin(camera, rho);
  const T x_host[3] = {z / b_host * (x_V - camera.c.x()) * camera.s,
                       z / b_host * (y_V - camera.c.y()) * camera.s,
                       z};
  T x_target[3];
  target_from_host(x_host, x_target);
  const T b = ImageDistanceTwin(camera, 1.0 / x_target[2]);
  *u = x_target[0] / x_target[2] * b / camera.s + camera.c.x();
  *v = x_target[1] / x_target[2] * b / camera.s + camera.c.y();
}

// Eq. (20) for a pattern. Where `gradient` is given, the target image is replaced by a plane with
// that gradient in each pixel of the pattern: the derivative is then that of the geometry and the
// brightness at the states passed in with the image gradient of another state, as first estimates
// have it.
struct PhotometricTwin {
  const PhotometricPatch* patch;
  double sigma;
  ImageViewF target_image;
  const PlenopticProjection* camera;
  const Eigen::Matrix<double, kPatternSize, 2>* gradient = nullptr;

  template <typename T>
  bool operator()(const T* host, const T* target, const T* rho, T* residuals) const {
    for (int k = 0; k < kPatternSize; ++k) {
      T u, v;
      ProjectTwin(
          *camera,
          patch->px.x() + kPattern[k][0],
          patch->px.y() + kPattern[k][1],
          *rho,
          [&](const T* x_host, T* x_target) {
            T x_world[3];
            InverseTransformPoint(host, x_host, x_world);
            TransformPoint(target, x_world, x_target);
          },
          &u,
          &v);
      const T value = gradient != nullptr ? (*gradient)(k, 0) * u + (*gradient)(k, 1) * v
                                          : InterpolateWithDerivatives(target_image, u, v);
      const T gain = exp(target[7]) / exp(host[7]);
      residuals[k] =
          static_cast<double>(patch->weight[k]) / sigma *
          ((value - target[8]) - gain * (static_cast<double>(patch->intensity[k]) - host[8]));
    }
    return true;
  }
};

// The tracker's residual of a pixel: state = [target_from_reference (7); a; b].
struct PixelTwin {
  const ReferencePixel* pixel;
  ImageViewF target_image;
  const PlenopticProjection* camera;

  template <typename T>
  bool operator()(const T* state, const T* rho, T* residual) const {
    const Eigen::Vector2d px = pixel->m * (camera->f / camera->s) + camera->c;
    T u, v;
    ProjectTwin(
        *camera,
        px.x(),
        px.y(),
        *rho,
        [&](const T* x, T* transformed) { TransformPoint(state, x, transformed); },
        &u,
        &v);
    residual[0] = InterpolateWithDerivatives(target_image, u, v) -
                  exp(state[7]) * pixel->intensity - state[8];
    return true;
  }
};

// A (x [-] x_lin) + b of LinearPrior for one frame state; right to first order at x = x_lin, where
// it is compared.
struct FramePriorTwin {
  const double* linearization;  // 9
  Eigen::MatrixXd A;            // rows x 8

  template <typename T>
  bool operator()(const T* frame, T* residuals) const {
    const T y_wxyz[4] = {frame[3], frame[0], frame[1], frame[2]};
    const T x_inverse_wxyz[4] = {
        T(linearization[3]), T(-linearization[0]), T(-linearization[1]), T(-linearization[2])};
    T difference_wxyz[4], w[3], moved[3];
    ceres::QuaternionProduct(y_wxyz, x_inverse_wxyz, difference_wxyz);
    ceres::QuaternionToAngleAxis(difference_wxyz, w);
    const T x_translation[3] = {T(linearization[4]), T(linearization[5]), T(linearization[6])};
    ceres::QuaternionRotatePoint(difference_wxyz, x_translation, moved);
    // V(w)^-1 = I to lowest order, and t = y - R x vanishes at x_lin.
    Eigen::Matrix<T, 8, 1> difference;
    for (int i = 0; i < 3; ++i) {
      difference(i) = frame[4 + i] - moved[i];
      difference(3 + i) = w[i];
    }
    difference(6) = frame[7] - linearization[7];
    difference(7) = frame[8] - linearization[8];
    const Eigen::Matrix<T, Eigen::Dynamic, 1> r = A.cast<T>() * difference;
    for (Eigen::Index i = 0; i < r.size(); ++i) residuals[i] = r(i);
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
