// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/pinhole_view.h"

#include <gtest/gtest.h>

#include "prism/camera/projection.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

TEST(PinholeView, PlaneAppearsWhereThePinholeCameraSeesIt) {
  const PlenopticCamera camera = SmallCamera();
  const PlenopticProjection projection(camera);
  const double z = 1.5;
  const float w = static_cast<float>(InverseVirtualDepth(projection, 1 / z));
  LightFieldFrame frame;
  ImageF image(160, 160);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 160; ++x) image(x, y) = static_cast<float>(x + 0.5 * y);
  }
  frame.image.push_back(image);
  frame.inverse_virtual_depth = ImageF(160, 160, w);
  frame.sigma = ImageF(160, 160, 0.004f);
  const PinholeFrame view = MakePinholeView(camera, frame, ImageF(160, 160, w));
  const PinholeCamera pinhole = PinholeView(camera);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(80, 80), Eigen::Vector2d(40, 100)}) {
    const int x = static_cast<int>(pixel.x());
    const int y = static_cast<int>(pixel.y());
    EXPECT_NEAR(view.depth(x, y), z, 1e-3);
    const Eigen::Vector3d p_in_cam(
        z * (x - pinhole.cx) / pinhole.fx, z * (y - pinhole.cy) / pinhole.fy, z);
    Eigen::Vector3d x_V;
    ASSERT_TRUE(Project(projection, p_in_cam, &x_V));
    EXPECT_NEAR(view.image(x, y), x_V.x() + 0.5 * x_V.y(), 1e-2);
  }
}

TEST(PinholeView, CropKeepsTheRays) {
  const PinholeCamera camera{640, 480, 500, 500, 310, 250};
  int left = 0;
  int top = 0;
  const PinholeCamera cropped = CropToFieldOfView(camera, 30, &left, &top);
  EXPECT_LT(cropped.width, camera.width);
  EXPECT_DOUBLE_EQ((left - camera.cx) / camera.fx, (0 - cropped.cx) / cropped.fx);
  EXPECT_NEAR(2 * std::atan(0.5 * cropped.width / cropped.fx) * 180 / M_PI, 30, 0.3);
}

}  // namespace
}  // namespace prism
