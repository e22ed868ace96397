// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/plenoptic_optics.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>

namespace prism {
namespace {

// The share of a disc's area (radius r > 0) that lies within another one (radius R), their centres
// at a distance d.
double DiscOverlap(double d, double r, double R) {
  if (d + r <= R) return 1;
  if (d >= r + R) return 0;
  if (d + R <= r) return R * R / (r * r);
  const double cos_r = std::clamp((d * d + r * r - R * R) / (2 * d * r), -1.0, 1.0);
  const double cos_R = std::clamp((d * d + R * R - r * r) / (2 * d * R), -1.0, 1.0);
  // Two circular segments.
  const double segment_r = r * r * (std::acos(cos_r) - cos_r * std::sqrt(1 - cos_r * cos_r));
  const double segment_R = R * R * (std::acos(cos_R) - cos_R * std::sqrt(1 - cos_R * cos_R));
  return (segment_r + segment_R) / (M_PI * r * r);
}

}  // namespace

bool OpticsOptions::IsValid(std::string* error) const {
  if (!(micro_lens_aperture >= 0 && micro_lens_aperture <= 1)) {
    *error = "micro-lens aperture of " + std::to_string(micro_lens_aperture) +
             " pitches, expected 0 (pinhole) to 1";
  } else if (!(main_lens_aperture > 0 && main_lens_aperture <= 2)) {
    *error = "main-lens aperture of " + std::to_string(main_lens_aperture) +
             ", expected more than 0 and up to 2 (1 fills the pitch)";
  } else {
    return true;
  }
  return false;
}

PlenopticOptics::PlenopticOptics(const PlenopticCamera& camera, const OpticsOptions& options)
    : camera_(camera) {
  CHECK(camera.micro_lens_grid.has_value());
  const double pitch = camera.micro_lens_grid->diameter_px * camera.raw_pixel_size;
  const double b_L0 = camera.main_lens_mla_distance;
  const double B = camera.sensor_mla_distance;
  // Pitch of the micro lenses themselves, Eq. (8).
  const double lens_pitch = camera.adjust_micro_lens_centers ? pitch * b_L0 / (b_L0 + B) : pitch;
  micro_lens_radius_ = 0.5 * options.micro_lens_aperture * lens_pitch;
  main_lens_radius_ = 0.5 * options.main_lens_aperture * pitch * b_L0 / B;
  for (const MicroLensType& type : camera.micro_lens_grid->types) {
    inverse_focus_.push_back(camera.virtual_depth_sign() * type.FocusInverseVirtualDepth());
  }
}

PlenopticOptics::MicroLens PlenopticOptics::LensOf(const Eigen::Vector2d& raw_px) const {
  const MicroLensGrid& grid = *camera_.micro_lens_grid;
  const LensIndex index = grid.NearestLens(raw_px, camera_.raw_width, camera_.raw_height);
  const Eigen::Vector2d c_I = grid.MicroImageCenter(index, camera_.raw_width, camera_.raw_height) -
                              camera_.raw_principal_point;
  MicroLens lens;
  lens.center = camera_.distortion.Undistort(c_I * camera_.raw_pixel_size);
  if (camera_.adjust_micro_lens_centers) {
    const double b_L0 = camera_.main_lens_mla_distance;
    lens.center *= b_L0 / (b_L0 + camera_.sensor_mla_distance);  // Eq. (8)
  }
  lens.type = grid.TypeOf(index);
  return lens;
}

bool PlenopticOptics::Trace(const Eigen::Vector2d& raw_px,
                            const MicroLens& lens,
                            const Eigen::Vector2d& lens_sample,
                            Ray* ray) const {
  const Eigen::Vector2d p =
      camera_.distortion.Undistort((raw_px - camera_.raw_principal_point) * camera_.raw_pixel_size);
  const Eigen::Vector2d u = lens_sample * micro_lens_radius_;
  const Eigen::Vector2d m =
      (p - lens.center - u * inverse_focus_[lens.type]) / camera_.sensor_mla_distance;
  const Eigen::Vector2d a = lens.center + u - m * camera_.main_lens_mla_distance;
  if (a.squaredNorm() > main_lens_radius_ * main_lens_radius_) return false;
  ray->origin_xy = -a;
  ray->direction_xy = m + a / camera_.focal_length;
  return true;
}

double PlenopticOptics::Transmission(const Eigen::Vector2d& raw_px, const MicroLens& lens) const {
  constexpr int kSide = 6;  // points along the pixel's side
  const double magnification = camera_.main_lens_mla_distance / camera_.sensor_mla_distance;
  const double radius =
      micro_lens_radius_ * std::abs(1 + inverse_focus_[lens.type] * magnification);
  const double cos2 = 1 / (1 + (lens.center / camera_.main_lens_mla_distance).squaredNorm());
  const auto distance = [&](const Eigen::Vector2d& at_px) {
    const Eigen::Vector2d at = (at_px - camera_.raw_principal_point) * camera_.raw_pixel_size;
    return (lens.center - (camera_.distortion.Undistort(at) - lens.center) * magnification).norm();
  };
  // How far the disc moves over half the pixel, with room for distortion.
  const double over_pixel = 0.8 * camera_.raw_pixel_size * magnification;
  if (distance(raw_px) + over_pixel + radius <= main_lens_radius_) return cos2 * cos2;
  double open = 0;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double a = distance(raw_px + Eigen::Vector2d(i + 0.5, j + 0.5) / kSide -
                                Eigen::Vector2d::Constant(0.5));
      if (radius > 0) {
        open += DiscOverlap(a, radius, main_lens_radius_);
      } else if (a <= main_lens_radius_) {
        open += 1;
      }
    }
  }
  return cos2 * cos2 * open / (kSide * kSide);
}

double PlenopticOptics::SpotDiameter(int type, double v) const {
  const double defocus = camera_.virtual_depth_sign() / v - inverse_focus_[type];
  return 2 * micro_lens_radius_ * std::abs(defocus) / camera_.raw_pixel_size;
}

double PlenopticOptics::SpotDiameterAtDepth(int type, double z) const {
  const double b_L = 1 / (1 / camera_.focal_length - 1 / z);  // Eq. (2)
  const double B = camera_.virtual_depth_sign() * camera_.sensor_mla_distance;
  return SpotDiameter(type, (b_L - camera_.main_lens_mla_distance) / B);
}

double PlenopticOptics::Footprint(double z) const {
  const double f = camera_.focal_length;
  const double b_L0 = camera_.main_lens_mla_distance;
  return camera_.raw_pixel_size / camera_.sensor_mla_distance * std::abs(z * (1 - b_L0 / f) + b_L0);
}

}  // namespace prism
