// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "prism/board/calibration_board.h"
#include "prism/calibration/corner_observation.h"
#include "prism/camera/projection.h"

namespace prism {

inline PlenopticCamera CameraToCalibrate() {
  PlenopticCamera camera;
  camera.focal_length = 16.748e-3;
  camera.main_lens_mla_distance = 15.893e-3;
  camera.sensor_mla_distance = 0.376e-3;
  camera.raw_width = camera.raw_height = 2048;
  camera.raw_pixel_size = 5.5e-6;
  camera.raw_principal_point = {1018.7, 1054.2};
  return camera;
}

struct SyntheticViews {
  int count = 20;
  double nearest_m = 0.4, farthest_m = 2.5;  // evenly in inverse distance
  double max_tilt = 0.7;                     // rad
  double px_sigma = 0.1;                     // raw px
  double slope_sigma = 0.0004;
  double offset_sigma = 0.0002;  // of 1/v, from view to view
};

// How a corner shows in a raw image, by the equations of prism/camera alone.
inline CornerObservation ObserveExactly(const PlenopticCamera& camera,
                                        const Eigen::Vector3d& x_C,
                                        double w_offset) {
  const PlenopticProjection projection(camera);
  const double w = InverseVirtualDepth(projection, 1 / x_C.z());
  Eigen::Vector3d x_V;
  Project(projection, x_C, &x_V);
  const Eigen::Vector2d at = RawFromFocused(camera, x_V.head<2>());
  CornerObservation seen;
  // A micro image some pixels from where the ray through the main lens' centre goes.
  const double b_L = 1 / (1 / camera.focal_length - 1 / x_C.z());
  const double chief = (camera.main_lens_mla_distance + camera.sensor_mla_distance) / b_L;
  seen.micro_image_px =
      DistortRaw(camera, camera.raw_principal_point + chief * (at - camera.raw_principal_point)) +
      Eigen::Vector2d(2, -3);
  const Eigen::Vector2d lens = MicroLensCenter(camera, UndistortRaw(camera, seen.micro_image_px));
  seen.px = DistortRaw(camera, ProjectToRaw(camera, {at.x(), at.y(), 1 / w}, lens));
  const double kappa =
      camera.main_lens_mla_distance / (camera.main_lens_mla_distance + camera.sensor_mla_distance);
  seen.slope = (1 - camera.virtual_depth_sign() * (w + w_offset)) * kappa;
  return seen;
}

inline std::vector<BoardView> MakeViews(const CalibrationBoard& board,
                                        const PlenopticCamera& camera,
                                        const SyntheticViews& what,
                                        uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Eigen::Vector3d middle(
      0.5 * board.columns * board.square_m, 0.5 * board.rows * board.square_m, 0);
  std::vector<BoardView> views;
  for (int k = 0; k < what.count; ++k) {
    const double part = what.count > 1 ? k / (what.count - 1.0) : 0;
    const double z = 1 / ((1 - part) / what.nearest_m + part / what.farthest_m);
    const double direction = M_PI * uniform(random);
    const Eigen::Matrix3d R =
        (Eigen::AngleAxisd(what.max_tilt * std::abs(uniform(random)),
                           Eigen::Vector3d(std::cos(direction), std::sin(direction), 0)) *
         Eigen::AngleAxisd(0.5 * uniform(random), Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    const Eigen::Vector3d t(0.15 * z * uniform(random), 0.15 * z * uniform(random), z);
    const double offset = what.offset_sigma * normal(random);
    BoardView view;
    view.name = "view " + std::to_string(k);
    for (int i = 0; i < board.num_corners(); ++i) {
      const Eigen::Vector3d x_C = R * (board.CornerPosition(i) - middle) + t;
      CornerObservation corner = ObserveExactly(camera, x_C, offset);
      corner.corner = i;
      corner.px_sigma = what.px_sigma;
      corner.slope_sigma = what.slope_sigma;
      corner.px += what.px_sigma * Eigen::Vector2d(normal(random), normal(random));
      corner.slope += what.slope_sigma * normal(random);
      if ((corner.px.array() < 0).any() || (corner.px.array() > camera.raw_width).any()) continue;
      view.corners.push_back(corner);
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace prism
