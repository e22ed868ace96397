// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "prism/camera/plenoptic_camera.h"
#include "prism/geometry/se3.h"

namespace prism {

// The figures the projection needs (theta of Eq. (18)) on one level of a focused-image pyramid.
//
// Coordinates: x_C in metres in the camera frame (x right, y down, z forward, origin at the main
// lens); x'_V = (px, px, virtual depth v) on the focused grid of that level. rho = 1 / z_C is the
// metric inverse depth in 1/m and may be 0 (infinitely far). A point is valid only beyond the focal
// length, z_C > f_L, that is rho f_L < 1.
//
// Worth knowing: with b_L of Eq. (2), Eq. (10) is x'_V - c = (f_L / s) x_C / (z_C - f_L). The
// focused image is a pinhole image whose centre of projection is the front focal point (0, 0, f_L)
// and whose focal length is f_L / s px. It follows that the image of a viewing ray in another
// frame, the epipolar curve, is a straight line.
struct PlenopticProjection {
  double f = 0;                                 // f_L, m
  double b_L0 = 0;                              // m
  double B = 0;                                 // m
  double s = 0;                                 // s_x = s_y, focused pixel size, m
  Eigen::Vector2d c = Eigen::Vector2d::Zero();  // c_L, focused px
  int width = 0;                                // focused px
  int height = 0;

  PlenopticProjection() = default;
  explicit PlenopticProjection(const PlenopticCamera& camera, int level = 0);

  double FocalLengthPx() const { return f / s; }
};

// ---- metric inverse depth rho <-> inverse virtual depth w = 1/v (Eqs. (2), (4), (85), (86)) ----

// w(rho), last line of Eq. (86); optional derivative, last line of Eq. (87).
// Precondition: rho f_L != 1 - f_L / b_L0 (a point on the micro-lens array, v = 0).
double InverseVirtualDepth(const PlenopticProjection& camera,
                           double rho,
                           double* dw_drho = nullptr);

// rho(w), Eq. (85); negative beyond infinity. Optional derivative. Precondition: w > 0.
double InverseDepth(const PlenopticProjection& camera, double w, double* drho_dw = nullptr);

// First-order propagation of a variance of w to a variance of rho and back.
double InverseDepthVariance(const PlenopticProjection& camera, double w, double w_variance);
double InverseVirtualDepthVariance(const PlenopticProjection& camera,
                                   double rho,
                                   double rho_variance);

// w of a point infinitely far, B / (f_L - b_L0).
double InverseVirtualDepthAtInfinity(const PlenopticProjection& camera);

// ---- camera frame <-> virtual image space ----

// Eq. (10). False (output untouched) if z_C <= f_L. Optional Jacobian: Eq. (47).
bool Project(const PlenopticProjection& camera,
             const Eigen::Vector3d& x_C,
             Eigen::Vector3d* x_V,
             Eigen::Matrix3d* J_x_C = nullptr);

// Eq. (12), from the pixel and the virtual depth in x_V. Precondition: v > 0 and the point not at
// infinity.
Eigen::Vector3d Unproject(const PlenopticProjection& camera, const Eigen::Vector3d& x_V);

// Eq. (17), from the pixel and the metric inverse depth, pixel held fixed. Optional derivative with
// respect to rho (Eqs. (81)-(83) with R = I). Precondition: rho != 0.
Eigen::Vector3d UnprojectInverseDepth(const PlenopticProjection& camera,
                                      const Eigen::Vector2d& x_V,
                                      double rho,
                                      Eigen::Vector3d* J_rho = nullptr);

// ---- one frame to another ----

// d (Exp(delta) x_C) / d delta at 0, tangent [translation; rotation] (Eq. (52), without its zero
// last row).
Eigen::Matrix<double, 3, 6> PointPoseJacobian(const Eigen::Vector3d& x_C);

struct FrameProjectionJacobians {
  // d x'_V,j over the target pose, cam_j_from_world <- Exp(delta) cam_j_from_world: Eq. (47) times
  // Eq. (52) (not the misprinted Eq. (72)).
  Eigen::Matrix<double, 3, 6> target_pose;
  // The same over the host pose: minus the above times Ad(target_from_host).
  Eigen::Matrix<double, 3, 6> host_pose;
  // d x'_V,j / d rho_i, Eq. (84).
  Eigen::Vector3d rho;
};

// Pi_pl of Eqs. (18)-(19): pixel and inverse depth in the host frame to x'_V in the target frame.
// Works for rho = 0 through the form of Eq. (19) multiplied by rho. False if the point is invalid
// in either frame (at or inside the focal length).
bool ProjectBetweenFrames(const PlenopticProjection& camera,
                          const Eigen::Vector2d& host_px,
                          double rho,
                          const SE3& target_from_host,
                          Eigen::Vector3d* x_V_target,
                          FrameProjectionJacobians* jacobians = nullptr);

// ---- raw image ----

// Eqs. (6)-(7): where the micro lens with centre c_ML images the virtual point (x'_V, y'_V, v);
// position and centre in one unit and one origin. Optional Jacobian with respect to x_V.
Eigen::Vector2d ProjectToRaw(const Eigen::Vector3d& x_V,
                             const Eigen::Vector2d& c_ML,
                             Eigen::Matrix<double, 2, 3>* J_x_V = nullptr);

// Eq. (8): micro-lens centre of a micro-image centre (undistorted raw px), scaled about the
// principal point; the same point if the camera does not adjust.
Eigen::Vector2d MicroLensCenter(const PlenopticCamera& camera, const Eigen::Vector2d& c_I_raw_px);

// Distortion on raw pixels (Distortion's header).
Eigen::Vector2d DistortRaw(const PlenopticCamera& camera, const Eigen::Vector2d& undistorted_px);
Eigen::Vector2d UndistortRaw(const PlenopticCamera& camera, const Eigen::Vector2d& distorted_px);

// Raw and focused grids.
Eigen::Vector2d RawFromFocused(const PlenopticCamera& camera, const Eigen::Vector2d& focused_px);
Eigen::Vector2d FocusedFromRaw(const PlenopticCamera& camera, const Eigen::Vector2d& raw_px);

// ---- pinhole view, supplement Section F ----

// Eqs. (88)-(89): the pixel on the plane 2B behind the array that shows the virtual point; all in
// focused px of the projection's level. Its inverse takes the metric inverse depth.
Eigen::Vector2d PinholeFromVirtual(const PlenopticProjection& camera, const Eigen::Vector3d& x_V);
Eigen::Vector2d VirtualFromPinhole(const PlenopticProjection& camera,
                                   const Eigen::Vector2d& pinhole_px,
                                   double rho);

}  // namespace prism
