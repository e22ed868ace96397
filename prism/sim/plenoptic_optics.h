// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prism/camera/plenoptic_camera.h"

namespace prism {

struct OpticsOptions {
  // Diameter of the round micro lenses, in pitches of the array. Larger: more light, more defocus.
  double micro_lens_aperture = 0.9;
  // Main-lens aperture, in diameters at which its image behind a pinhole micro lens is as wide as
  // the micro-image pitch (equal f-numbers). Larger: micro images overlap.
  double main_lens_aperture = 1.0;

  bool IsValid(std::string* error) const;
};

// The light path of a focused plenoptic camera, backwards: from a point on the sensor through a
// point on its micro lens and on the main lens out into the scene. Both lenses are thin and round.
//
// In unflipped image coordinates (metres about the principal point; physical positions have the
// opposite sign) the light that reaches the sensor point p through the point c + u of a micro lens
// with centre c has, before the micro lens, the slope
//     m = (p - c) / B - u / (v_k B),
// v_k the virtual depth on which that lens type is focused (1/f_k = (1 - 1/v_k) / B; it counts as
// negative in a Keplerian camera), crossed the
// main lens at a = c + u - m b_L0, and comes along the ray with origin (-a, 0) and direction
// (m + a / f_L, 1) in the camera frame. It is blocked if |a| exceeds the main lens' aperture.
class PlenopticOptics {
 public:
  struct MicroLens {
    Eigen::Vector2d center;  // c, m
    int type = 0;
  };
  struct Ray {
    Eigen::Vector2d origin_xy;     // at z = 0, m
    Eigen::Vector2d direction_xy;  // at z = 1
  };

  // Precondition: camera.IsValid and a micro-lens grid.
  PlenopticOptics(const PlenopticCamera& camera, const OpticsOptions& options);

  // The micro lens in whose cell a raw pixel lies: the one with the nearest micro-image centre.
  MicroLens LensOf(const Eigen::Vector2d& raw_px) const;

  // The ray of a raw pixel (distorted, as on the sensor) through the point `lens_sample` of its
  // micro lens' unit disc. False if the main lens' aperture blocks it.
  bool Trace(const Eigen::Vector2d& raw_px,
             const MicroLens& lens,
             const Eigen::Vector2d& lens_sample,
             Ray* ray) const;

  // The share of the light that reaches a pixel: the part of its micro lens that the main lens'
  // aperture leaves open, averaged over the pixel, times natural vignetting. On the main lens the
  // micro lens' opening is seen as a disc of radius r_l |1 + b_L0 / (B v_k)| about
  // c - (p - c) b_L0 / B, r_l its own; what is open is where that disc overlaps the aperture.
  //
  // Natural vignetting is cos^4 of the chief ray's angle, one value a micro lens. Ray by ray, the
  // thin main lens, a few millimetres before the array, would shade micro images far more to one
  // side than real lenses do, whose exit pupil is distant.
  double Transmission(const Eigen::Vector2d& raw_px, const MicroLens& lens) const;

  // |v_k|: the middle, in 1/v, of the type's depth range as far as it is above v = 2.
  double FocusVirtualDepth(int type) const { return std::abs(1 / inverse_focus_[type]); }

  // Diameter in raw px of the spot that a point of virtual depth v makes behind a lens of a type.
  double SpotDiameter(int type, double v) const;

  // The same for a point at depth z > f_L.
  double SpotDiameterAtDepth(int type, double z) const;

  // Side, at depth z, of the square a raw pixel sees through one point of its micro lens, m.
  double Footprint(double z) const;

  double main_lens_radius() const { return main_lens_radius_; }
  double micro_lens_radius() const { return micro_lens_radius_; }
  const PlenopticCamera& camera() const { return camera_; }

 private:
  PlenopticCamera camera_;
  double main_lens_radius_;
  double micro_lens_radius_;
  std::vector<double> inverse_focus_;  // 1 / v_k, negative in a Keplerian camera
};

}  // namespace prism
