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
// A Keplerian camera is one of negative B: b_L = b_L0 + v B then lies before the micro lenses for
// v > 0, and all equations and derivatives hold as they stand.
//
// Worth knowing: with b_L of Eq. (2), Eq. (10) is x'_V - c = (f_L / s) x_C / (z_C - f_L). The
// focused image is a pinhole image whose centre of projection is the front focal point (0, 0, f_L)
// and whose focal length is f_L / s px. It follows that the image of a viewing ray in another
// frame, the epipolar curve, is a straight line.
//
// A focused image of chief rays (FocusedImage::kChiefRays) is one of the same focal length, seen
// from the main lens: x'_V - c = (f_L / s) x_C / z_C. All that distinguishes the two is `center_z`,
// which stands for f_L wherever it is not the lens that is meant: Eqs. (10), (15), (17) and (84).
struct PlenopticProjection {
  double f = 0;     // f_L, m
  double b_L0 = 0;  // m
  double B = 0;     // m; negative: Keplerian
  double s = 0;     // s_x = s_y, focused pixel size, m
  FocusedImage image = FocusedImage::kVirtualPoints;
  Eigen::Vector2d c = Eigen::Vector2d::Zero();  // c_L, focused px
  int width = 0;                                // focused px
  int height = 0;

  PlenopticProjection() = default;
  explicit PlenopticProjection(const PlenopticCamera& camera, int level = 0);

  double FocalLengthPx() const { return f / s; }
  // z_C of the focused image's centre of projection, m.
  double center_z() const { return image == FocusedImage::kChiefRays ? 0 : f; }
};

// ---- metric inverse depth rho <-> inverse virtual depth w = 1/v (Eqs. (2), (4), (85), (86)) ----

// w(rho), last line of Eq. (86); optional derivative, last line of Eq. (87). Negative where the
// image lies on the other side of the micro-lens array than the mode's: beyond rho = 1 / f_L -
// 1 / b_L0, which is near the camera for Keplerian ones and behind infinity for Galilean ones.
// Precondition: rho is not that value (v = 0).
double InverseVirtualDepth(const PlenopticProjection& camera,
                           double rho,
                           double* dw_drho = nullptr);

// rho(w), Eq. (85); negative beyond infinity. Optional derivative. Precondition: w > 0 and the
// image is behind the main lens, w b_L0 + B > 0.
double InverseDepth(const PlenopticProjection& camera, double w, double* drho_dw = nullptr);

// First-order propagation of a variance of w to a variance of rho.
double InverseDepthVariance(const PlenopticProjection& camera, double w, double w_variance);

// w of a point infinitely far, B / (f_L - b_L0): the largest w of a Galilean camera, the smallest
// of a Keplerian one.
double InverseVirtualDepthAtInfinity(const PlenopticProjection& camera);

// ---- camera frame <-> virtual image space ----

// Eq. (10). False (output untouched) if z_C <= f_L. Optional Jacobian: Eq. (47).
bool Project(const PlenopticProjection& camera,
             const Eigen::Vector3d& x_C,
             Eigen::Vector3d* x_V,
             Eigen::Matrix3d* J_x_C = nullptr);

// Eqs. (12), (17), from the pixel and the metric inverse depth. Precondition: rho != 0.
Eigen::Vector3d UnprojectInverseDepth(const PlenopticProjection& camera,
                                      const Eigen::Vector2d& x_V,
                                      double rho);

// ---- one frame to another ----
//
// Points are carried from frame to frame times their inverse depth in the host frame,
//   X = rho x_C,j = R (m (1 - rho f_L), 1) + rho t,   m = (x'_V,i - c) s / f_L
// (Eqs. (15), (17) times rho), which stays finite for rho = 0.

// Eq. (17) times rho.
inline Eigen::Vector3d ScaledRay(const PlenopticProjection& camera,
                                 const Eigen::Vector2d& px,
                                 double rho) {
  const Eigen::Vector2d m = (px - camera.c) * (camera.s / camera.f);
  const double k = 1 - rho * camera.center_z();
  return {m.x() * k, m.y() * k, 1};
}

// The pixel of Eq. (10) for a scaled point X, and its derivative: what window, tracker and epipolar
// search project with. Made once for many points.
class ScaledProjection {
 public:
  explicit ScaledProjection(const PlenopticProjection& camera)
      : f_px_(camera.FocalLengthPx()),
        center_z_(camera.center_z()),
        cx_(camera.c.x()),
        cy_(camera.c.y()) {}

  struct Pixel {
    double x, y;   // focused px
    double D;      // rho (z_C - center_z)
    double alpha;  // dx / dX.x = dy / dX.y, Eq. (73) times rho
  };

  // False at or behind the centre of projection.
  bool Project(const Eigen::Vector3d& X, double rho, Pixel* pixel) const {
    *pixel = At(X, rho);
    return pixel->D > 0;
  }

  // The same of a point known to lie before it.
  Pixel At(const Eigen::Vector3d& X, double rho) const {
    const double D = X.z() - rho * center_z_;
    const double alpha = f_px_ / D;
    return {alpha * X.x() + cx_, alpha * X.y() + cy_, D, alpha};
  }

  // Derivative over X of a function of the pixel with gradient (gx, gy) there: (gx, gy) times the
  // first two rows of Eq. (47).
  static Eigen::Vector3d PullBack(const Pixel& pixel,
                                  const Eigen::Vector3d& X,
                                  double gx,
                                  double gy) {
    const double x = gx * pixel.alpha;
    const double y = gy * pixel.alpha;
    return {x, y, -(x * X.x() + y * X.y()) / pixel.D};
  }

  // The same over the target pose, [translation; rotation] on the left, given the derivative over X
  // (Eq. (52): translation moves X by rho delta_t, rotation by delta_w x X).
  static Vector6d OverPose(const Eigen::Vector3d& over_X, const Eigen::Vector3d& X, double rho) {
    Vector6d J;
    J[0] = rho * over_X.x();
    J[1] = rho * over_X.y();
    J[2] = rho * over_X.z();
    J[3] = X.y() * over_X.z() - X.z() * over_X.y();
    J[4] = X.z() * over_X.x() - X.x() * over_X.z();
    J[5] = X.x() * over_X.y() - X.y() * over_X.x();
    return J;
  }

  // The same over rho, given dX / drho (Eq. (84)); D depends on rho by itself as well.
  double OverInverseDepth(const Eigen::Vector3d& over_X, const Eigen::Vector3d& dX_drho) const {
    return over_X.x() * dX_drho.x() + over_X.y() * dX_drho.y() +
           over_X.z() * (dX_drho.z() - center_z_);
  }

 private:
  double f_px_, center_z_, cx_, cy_;
};

// Pi_pl of Eqs. (18)-(19): pixel and inverse depth in the host frame to x'_V in the target frame,
// also for rho = 0. False if the point is invalid in either frame (at or inside the focal length).
bool ProjectBetweenFrames(const PlenopticProjection& camera,
                          const Eigen::Vector2d& host_px,
                          double rho,
                          const RigidMotion& target_from_host,
                          Eigen::Vector3d* x_V_target);

// ---- raw image ----

// Eqs. (6)-(7): where the micro lens with centre c_ML images the virtual point (x'_V, y'_V, v), on
// the other side of the centre in a Keplerian camera; position and centre in one unit and one
// origin.
Eigen::Vector2d ProjectToRaw(const PlenopticCamera& camera,
                             const Eigen::Vector3d& x_V,
                             const Eigen::Vector2d& c_ML);

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

// The inverse of Eqs. (88)-(89): the focused pixel that shows the point which a pixel on the plane
// 2B behind the array shows; both in focused px of the projection's level.
Eigen::Vector2d VirtualFromPinhole(const PlenopticProjection& camera,
                                   const Eigen::Vector2d& pinhole_px,
                                   double rho);

}  // namespace prism
