// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/projection.h"

#include <cmath>

namespace prism {

PlenopticProjection::PlenopticProjection(const PlenopticCamera& camera, int level)
    : f(camera.focal_length), b_L0(camera.main_lens_mla_distance), B(camera.sensor_mla_distance) {
  const double scale = camera.focused_scale * std::ldexp(1.0, level);
  s = camera.raw_pixel_size * scale;
  c = (camera.raw_principal_point.array() + 0.5) / scale - 0.5;
  width = camera.focused_width() >> level;
  height = camera.focused_height() >> level;
}

double InverseVirtualDepth(const PlenopticProjection& camera, double rho, double* dw_drho) {
  const double denominator = rho * camera.f * camera.b_L0 + camera.f - camera.b_L0;
  if (dw_drho != nullptr) {
    *dw_drho = -camera.B * camera.f * camera.f / (denominator * denominator);  // Eq. (87)
  }
  return camera.B * (1 - rho * camera.f) / denominator;  // Eq. (86)
}

double InverseDepth(const PlenopticProjection& camera, double w, double* drho_dw) {
  const double inverse_b_L = w / (camera.B + w * camera.b_L0);  // Eq. (4)
  if (drho_dw != nullptr) *drho_dw = -camera.B * (inverse_b_L * inverse_b_L) / (w * w);
  return 1 / camera.f - inverse_b_L;  // Eq. (85)
}

double InverseDepthVariance(const PlenopticProjection& camera, double w, double w_variance) {
  double drho_dw;
  InverseDepth(camera, w, &drho_dw);
  return drho_dw * drho_dw * w_variance;
}

double InverseVirtualDepthVariance(const PlenopticProjection& camera,
                                   double rho,
                                   double rho_variance) {
  double dw_drho;
  InverseVirtualDepth(camera, rho, &dw_drho);
  return dw_drho * dw_drho * rho_variance;
}

double InverseVirtualDepthAtInfinity(const PlenopticProjection& camera) {
  return camera.B / (camera.f - camera.b_L0);
}

bool Project(const PlenopticProjection& camera,
             const Eigen::Vector3d& x_C,
             Eigen::Vector3d* x_V,
             Eigen::Matrix3d* J_x_C) {
  const double z_minus_f = x_C.z() - camera.f;
  if (!(z_minus_f > 0)) return false;
  const double alpha = camera.f / (camera.s * z_minus_f);  // Eq. (73)
  const double b_L = camera.f * x_C.z() / z_minus_f;       // Eq. (2)
  *x_V << alpha * x_C.x() + camera.c.x(), alpha * x_C.y() + camera.c.y(),
      (b_L - camera.b_L0) / camera.B;  // Eq. (10)
  if (J_x_C != nullptr) {
    const double beta = -camera.f * camera.f / (camera.B * z_minus_f * z_minus_f);  // Eq. (75)
    *J_x_C << alpha, 0, -alpha * x_C.x() / z_minus_f,                               //
        0, alpha, -alpha * x_C.y() / z_minus_f,                                     //
        0, 0, beta;                                                                 // Eq. (47)
  }
  return true;
}

Eigen::Vector3d Unproject(const PlenopticProjection& camera, const Eigen::Vector3d& x_V) {
  const double b_L = x_V.z() * camera.B + camera.b_L0;  // Eq. (4)
  return UnprojectInverseDepth(camera, x_V.head<2>(), 1 / camera.f - 1 / b_L);
}

Eigen::Vector3d UnprojectInverseDepth(const PlenopticProjection& camera,
                                      const Eigen::Vector2d& x_V,
                                      double rho,
                                      Eigen::Vector3d* J_rho) {
  const Eigen::Vector2d m = (x_V - camera.c) * (camera.s / camera.f);
  const double z = 1 / rho;
  if (J_rho != nullptr) *J_rho = -z * z * Eigen::Vector3d(m.x(), m.y(), 1);  // Eqs. (81)-(83)
  // Eq. (17) with z / b_L = z / f - 1.
  const double z_minus_f = z - camera.f;
  return {m.x() * z_minus_f, m.y() * z_minus_f, z};
}

Eigen::Matrix<double, 3, 6> PointPoseJacobian(const Eigen::Vector3d& x_C) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -Skew(x_C);
  return J;
}

bool ProjectBetweenFrames(const PlenopticProjection& camera,
                          const Eigen::Vector2d& host_px,
                          double rho,
                          const SE3& target_from_host,
                          Eigen::Vector3d* x_V_target,
                          FrameProjectionJacobians* jacobians) {
  const double f = camera.f;
  if (!(rho * f < 1)) return false;
  const Eigen::Vector2d m = (host_px - camera.c) * (camera.s / f);
  const Eigen::Matrix3d R = target_from_host.RotationMatrix();
  const Eigen::Vector3d t = target_from_host.translation();
  // rho times Eq. (17) and Eq. (15); finite for rho = 0.
  const Eigen::Vector3d ray(m.x() * (1 - rho * f), m.y() * (1 - rho * f), 1);
  const Eigen::Vector3d X = R * ray + rho * t;
  const double D = X.z() - rho * f;  // rho (z_C,j - f_L)
  if (!(D > 0)) return false;
  const double alpha = f / (camera.s * D);
  const double b_L = f * X.z() / D;
  *x_V_target << alpha * X.x() + camera.c.x(), alpha * X.y() + camera.c.y(),
      (b_L - camera.b_L0) / camera.B;  // Eq. (19)
  if (jacobians != nullptr) {
    // Eq. (47) divided by rho, so that it multiplies derivatives of X.
    const double beta = -f * f / (camera.B * D * D);
    Eigen::Matrix3d J_x;
    J_x << alpha, 0, -alpha * X.x() / D,  //
        0, alpha, -alpha * X.y() / D,     //
        0, 0, beta * rho;
    // rho d x_C,j / d delta, Eq. (52).
    Eigen::Matrix<double, 3, 6> J_delta;
    J_delta << rho * Eigen::Matrix3d::Identity(), -Skew(X);
    jacobians->target_pose = J_x * J_delta;
    jacobians->host_pose = -jacobians->target_pose * target_from_host.Adjoint();
    // X = rho x_C, so rho dx_C/drho = dX/drho - X / rho = (t - f R [m; 0]) - X / rho; the
    // projection does not change along X itself except through f: d/drho of (X, D) taken directly.
    const Eigen::Vector3d dX = t - f * (R * Eigen::Vector3d(m.x(), m.y(), 0));
    const double dD = dX.z() - f;
    jacobians->rho << alpha * (dX.x() - X.x() * dD / D), alpha * (dX.y() - X.y() * dD / D),
        f * (dX.z() - X.z() * dD / D) / (D * camera.B);  // Eq. (84)
  }
  return true;
}

Eigen::Vector2d ProjectToRaw(const Eigen::Vector3d& x_V,
                             const Eigen::Vector2d& c_ML,
                             Eigen::Matrix<double, 2, 3>* J_x_V) {
  const double w = 1 / x_V.z();
  const Eigen::Vector2d offset = x_V.head<2>() - c_ML;
  if (J_x_V != nullptr) *J_x_V << w, 0, -w * w * offset.x(), 0, w, -w * w * offset.y();
  return offset * w + c_ML;
}

Eigen::Vector2d MicroLensCenter(const PlenopticCamera& camera, const Eigen::Vector2d& c_I_raw_px) {
  if (!camera.adjust_micro_lens_centers) return c_I_raw_px;
  const double scale =
      camera.main_lens_mla_distance / (camera.main_lens_mla_distance + camera.sensor_mla_distance);
  return camera.raw_principal_point + scale * (c_I_raw_px - camera.raw_principal_point);
}

Eigen::Vector2d DistortRaw(const PlenopticCamera& camera, const Eigen::Vector2d& undistorted_px) {
  const double s = camera.raw_pixel_size;
  const Eigen::Vector2d c = camera.raw_principal_point;
  return camera.distortion.Distort((undistorted_px - c) * s) / s + c;
}

Eigen::Vector2d UndistortRaw(const PlenopticCamera& camera, const Eigen::Vector2d& distorted_px) {
  const double s = camera.raw_pixel_size;
  const Eigen::Vector2d c = camera.raw_principal_point;
  return camera.distortion.Undistort((distorted_px - c) * s) / s + c;
}

Eigen::Vector2d RawFromFocused(const PlenopticCamera& camera, const Eigen::Vector2d& focused_px) {
  return (focused_px.array() + 0.5) * camera.focused_scale - 0.5;
}

Eigen::Vector2d FocusedFromRaw(const PlenopticCamera& camera, const Eigen::Vector2d& raw_px) {
  return (raw_px.array() + 0.5) / camera.focused_scale - 0.5;
}

Eigen::Vector2d PinholeFromVirtual(const PlenopticProjection& camera, const Eigen::Vector3d& x_V) {
  const double b_L = x_V.z() * camera.B + camera.b_L0;
  return (x_V.head<2>() - camera.c) * ((2 * camera.B + camera.b_L0) / b_L) + camera.c;
}

Eigen::Vector2d VirtualFromPinhole(const PlenopticProjection& camera,
                                   const Eigen::Vector2d& pinhole_px,
                                   double rho) {
  const double b_L = camera.f / (1 - rho * camera.f);  // Eq. (2)
  return (pinhole_px - camera.c) * (b_L / (2 * camera.B + camera.b_L0)) + camera.c;
}

}  // namespace prism
