// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/projection.h"

#include <cmath>

namespace prism {

PlenopticProjection::PlenopticProjection(const PlenopticCamera& camera, int level)
    : f(camera.focal_length),
      b_L0(camera.main_lens_mla_distance),
      B(camera.virtual_depth_sign() * camera.sensor_mla_distance),
      image(camera.focused_image) {
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

double InverseVirtualDepthAtInfinity(const PlenopticProjection& camera) {
  return camera.B / (camera.f - camera.b_L0);
}

bool Project(const PlenopticProjection& camera,
             const Eigen::Vector3d& x_C,
             Eigen::Vector3d* x_V,
             Eigen::Matrix3d* J_x_C) {
  const double z_minus_f = x_C.z() - camera.f;
  if (!(z_minus_f > 0)) return false;
  const double zeta = x_C.z() - camera.center_z();
  const double alpha = camera.f / (camera.s * zeta);  // Eq. (73)
  const double b_L = camera.f * x_C.z() / z_minus_f;  // Eq. (2)
  *x_V << alpha * x_C.x() + camera.c.x(), alpha * x_C.y() + camera.c.y(),
      (b_L - camera.b_L0) / camera.B;  // Eq. (10)
  if (J_x_C != nullptr) {
    const double beta = -camera.f * camera.f / (camera.B * z_minus_f * z_minus_f);  // Eq. (75)
    *J_x_C << alpha, 0, -alpha * x_C.x() / zeta,                                    //
        0, alpha, -alpha * x_C.y() / zeta,                                          //
        0, 0, beta;                                                                 // Eq. (47)
  }
  return true;
}

Eigen::Vector3d UnprojectInverseDepth(const PlenopticProjection& camera,
                                      const Eigen::Vector2d& x_V,
                                      double rho) {
  const Eigen::Vector2d m = (x_V - camera.c) * (camera.s / camera.f);
  const double z = 1 / rho;
  // Eq. (17), where z / b_L = z / f - 1.
  const double zeta = z - camera.center_z();
  return {m.x() * zeta, m.y() * zeta, z};
}

bool ProjectBetweenFrames(const PlenopticProjection& camera,
                          const Eigen::Vector2d& host_px,
                          double rho,
                          const RigidMotion& target_from_host,
                          Eigen::Vector3d* x_V_target) {
  if (!(rho * camera.f < 1)) return false;
  const Eigen::Vector3d X =
      target_from_host.R * ScaledRay(camera, host_px, rho) + rho * target_from_host.t;
  ScaledProjection::Pixel pixel;
  const double z_minus_f = X.z() - rho * camera.f;  // times rho
  if (!(z_minus_f > 0) || !ScaledProjection(camera).Project(X, rho, &pixel)) return false;
  const double b_L = camera.f * X.z() / z_minus_f;                  // Eq. (2)
  *x_V_target << pixel.x, pixel.y, (b_L - camera.b_L0) / camera.B;  // Eq. (19)
  return true;
}

Eigen::Vector2d ProjectToRaw(const PlenopticCamera& camera,
                             const Eigen::Vector3d& x_V,
                             const Eigen::Vector2d& c_ML) {
  return (x_V.head<2>() - c_ML) * (camera.virtual_depth_sign() / x_V.z()) + c_ML;
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

Eigen::Vector2d VirtualFromPinhole(const PlenopticProjection& camera,
                                   const Eigen::Vector2d& pinhole_px,
                                   double rho) {
  // b_L of Eq. (2) for virtual points.
  const double b_L = camera.f / (1 - rho * camera.center_z());
  return (pinhole_px - camera.c) * (b_L / (2 * camera.B + camera.b_L0)) + camera.c;
}

}  // namespace prism
