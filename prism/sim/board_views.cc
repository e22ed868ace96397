// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/board_views.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/Geometry>

#include "prism/sim/counter_random.h"

namespace prism {
namespace {

// Width of the target over that of the image, in the farthest and the nearest picture.
constexpr double kSmallest = 0.16;
constexpr double kLargest = 1.2;
constexpr double kRoll = 0.5;  // rad

double Between(double low, double high, CounterRandom* random) {
  return low + (high - low) * random->Uniform();
}

std::vector<int> Shuffled(int count, CounterRandom* random) {
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (int i = count - 1; i > 0; --i) {
    std::swap(order[i], order[static_cast<int>(random->Uniform() * (i + 1))]);
  }
  return order;
}

}  // namespace

bool BoardViewOptions::IsValid(std::string* error) const {
  if (num_views < 1 || num_views > 100000) {
    *error = std::to_string(num_views) + " frames, expected 1 to 100000";
  } else if (!(rate_hz > 0 && rate_hz <= 1e6)) {
    *error = "a rate of " + std::to_string(rate_hz) + " Hz, expected more than 0";
  } else if (!(max_tilt_deg >= 0 && max_tilt_deg <= 60)) {
    *error = "a tilt of " + std::to_string(max_tilt_deg) + " degrees, expected 0 to 60";
  } else {
    return true;
  }
  return false;
}

CameraMotion GenerateBoardViews(const BoardViewOptions& options,
                                const PlenopticCamera& camera,
                                const SimPath& path) {
  CounterRandom random(options.seed, 77, 0);
  const double half_view =
      0.5 * camera.raw_width * camera.raw_pixel_size / camera.main_lens_mla_distance;  // tangent
  const Eigen::Vector3d normal = (path.position - path.target).normalized();
  const Eigen::Vector3d across = normal.cross(Eigen::Vector3d::UnitZ()).normalized();
  const std::vector<int> order = Shuffled(options.num_views, &random);

  std::vector<SE3> poses;
  for (const int rank : order) {
    const double part = (rank + 0.5) / options.num_views;
    const double width = kSmallest + (kLargest - kSmallest) * part;
    const double distance = path.extent / (width * half_view);
    // The board's normal in the camera's view: tilted about an axis in the image plane.
    const double tilt = options.max_tilt_deg * M_PI / 180 * std::sqrt(Between(0.05, 1, &random));
    const double tilt_axis = Between(0, 2 * M_PI, &random);
    const Eigen::Vector3d direction =
        Eigen::AngleAxisd(
            tilt, std::cos(tilt_axis) * across + std::sin(tilt_axis) * normal.cross(across)) *
        normal;
    // Where in the image the middle of the board is.
    const double room = std::abs(1 - width);
    const double x = half_view * room * Between(-0.95, 0.95, &random);
    const double y = half_view * room * Between(-0.95, 0.95, &random);
    const Eigen::Vector3d z = -direction;
    const Eigen::Vector3d right = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d R;
    R << right, z.cross(right), z;
    R = R * Eigen::AngleAxisd(Between(-kRoll, kRoll, &random), Eigen::Vector3d::UnitZ());
    poses.emplace_back(Eigen::Quaterniond(R),
                       path.target - R * (distance * Eigen::Vector3d(x, y, 1)));
  }

  CameraMotion motion;
  for (int i = 0; i < options.num_views; ++i) {
    motion.frame_times_ns.push_back(std::llround(1e9 * i / options.rate_hz));
  }
  motion.world_from_cam = [poses, rate = options.rate_hz](double seconds) {
    const auto nearest = std::lround(seconds * rate);
    return poses[std::clamp<long>(nearest, 0, static_cast<long>(poses.size()) - 1)];
  };
  return motion;
}

}  // namespace prism
