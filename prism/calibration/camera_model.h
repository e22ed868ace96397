// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "prism/camera/plenoptic_camera.h"

namespace prism {

// The figures of a camera that are calibrated, as one parameter block. v_inf = (f_L - b_L0) / B,
// the virtual depth of infinity, stands for b_L0: it is what measured depth tells of it.
enum CameraParameter {
  kFocalLength,     // f_L, m
  kInfinityDepth,   // v_inf
  kSensorDistance,  // B, m, > 0 in either mode
  kPrincipalX,      // c_L, raw px
  kPrincipalY,
  kRadial0,      // A0, 1/m^2
  kRadial1,      // A1, 1/m^4
  kTangential0,  // B0, 1/m
  kTangential1,  // B1, 1/m
  kNumCameraParameters
};
using CameraParameters = std::array<double, kNumCameraParameters>;

CameraParameters ParametersOf(const PlenopticCamera& camera);
// The camera with these figures in place of its own.
PlenopticCamera WithParameters(const PlenopticCamera& camera, const CameraParameters& parameters);

// b_L0 / (b_L0 + B), what Eq. (8) scales centres of micro images by; 1 for a camera that does not.
inline double MicroLensCenterScale(const PlenopticCamera& camera) {
  if (!camera.adjust_micro_lens_centers) return 1;
  return camera.main_lens_mla_distance /
         (camera.main_lens_mla_distance + camera.sensor_mla_distance);
}

// What does not change when a camera is calibrated.
struct FixedFigures {
  explicit FixedFigures(const PlenopticCamera& camera)
      : pixel_size(camera.raw_pixel_size),
        sign(camera.virtual_depth_sign()),
        adjust(camera.adjust_micro_lens_centers) {}
  double pixel_size, sign;
  bool adjust;
};

// How a point before the camera shows in the raw image (CornerObservation's header).
template <typename T>
struct RawAppearance {
  Eigen::Matrix<T, 2, 1> chief_px;  // x_0, distorted raw px
  T kappa;                          // b_L0 / (b_L0 + B)
  T inverse_depth;                  // sign / v
  T Slope(const T& inverse_depth_offset) const {
    return (1.0 - inverse_depth - inverse_depth_offset) * kappa;
  }
};

// False if the point is within the focal length, or its image on the wrong side of the micro
// lenses.
template <typename T>
bool Appear(const FixedFigures& fixed,
            const T* parameters,
            const Eigen::Matrix<T, 3, 1>& x_C,
            RawAppearance<T>* result) {
  const T& f = parameters[kFocalLength];
  const T& B = parameters[kSensorDistance];
  if (!(x_C.z() > f) || !(B > 0.0)) return false;
  const T b_L0 = f - fixed.sign * parameters[kInfinityDepth] * B;
  const T b_L = f * x_C.z() / (x_C.z() - f);  // Eq. (2)
  const T q = B / (b_L - b_L0);               // sign / v, Eq. (4)
  if (!(fixed.sign * q > 0.0)) return false;
  result->inverse_depth = q;
  result->kappa = fixed.adjust ? b_L0 / (b_L0 + B) : T(1.0);  // Eq. (8)
  const T chief_scale = q / (1.0 - (1.0 - q) * result->kappa);
  // Metres about the principal point.
  const T scale = b_L * chief_scale / x_C.z();
  const T x = x_C.x() * scale;
  const T y = x_C.y() * scale;
  const T r2 = x * x + y * y;
  const T radial = r2 * (parameters[kRadial0] + r2 * parameters[kRadial1]);
  const T& B0 = parameters[kTangential0];
  const T& B1 = parameters[kTangential1];
  const T dx = x * radial + B0 * (r2 + 2.0 * x * x) + 2.0 * B1 * x * y;
  const T dy = y * radial + B1 * (r2 + 2.0 * y * y) + 2.0 * B0 * x * y;
  result->chief_px << parameters[kPrincipalX] + (x + dx) / fixed.pixel_size,
      parameters[kPrincipalY] + (y + dy) / fixed.pixel_size;
  return true;
}

}  // namespace prism
