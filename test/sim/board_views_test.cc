// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/board_views.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "prism/io/camera_file.h"

namespace prism {
namespace {

PlenopticCamera Camera() {
  return ReadPlenopticCamera(std::string(PRISM_SOURCE_DIR) + "/calib/raytrix_r5_16mm.yaml");
}

TEST(BoardViews, ShowTheBoardNearAndFarTiltedAndStill) {
  const PlenopticCamera camera = Camera();
  SimPath path;
  path.position = {-1.6, 0, 0};
  path.target = {0, 0, 0};
  path.extent = 0.18;
  BoardViewOptions options;
  const CameraMotion motion = GenerateBoardViews(options, camera, path);
  const double half_view =
      0.5 * camera.raw_width * camera.raw_pixel_size / camera.main_lens_mla_distance;
  double nearest = 1e9, farthest = 0, most_tilted = 0;
  for (const StampedPose& pose : motion.AtFrames()) {
    const SE3 cam_from_world = pose.world_from_cam.Inverse();
    const Eigen::Vector3d middle = cam_from_world * path.target;
    nearest = std::min(nearest, middle.z());
    farthest = std::max(farthest, middle.z());
    EXPECT_LT(middle.head<2>().cwiseAbs().maxCoeff() / middle.z(), half_view);
    const Eigen::Vector3d normal = cam_from_world.rotation() * Eigen::Vector3d(-1, 0, 0);
    const double cosine = -normal.z();
    EXPECT_GT(cosine, 0.6);  // it faces the camera
    most_tilted = std::max(most_tilted, std::acos(std::min(1.0, cosine)));
    // Still during an exposure.
    const double t = 1e-9 * static_cast<double>(pose.time_ns) + 0.01;
    EXPECT_EQ(motion.world_from_cam(t).translation(), pose.world_from_cam.translation());
  }
  EXPECT_GT(farthest, 5 * nearest);
  EXPECT_GT(most_tilted, 0.5);
}

TEST(BoardViews, AreTheSameForTheSameSeed) {
  const SimPath path;
  BoardViewOptions options;
  const auto poses = [&](uint64_t seed) {
    options.seed = seed;
    return GenerateBoardViews(options, Camera(), path).AtFrames()[3].world_from_cam.translation();
  };
  EXPECT_EQ(poses(4), poses(4));
  EXPECT_NE(poses(4), poses(5));
}

}  // namespace
}  // namespace prism
