// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/camera_model.h"

#include <gtest/gtest.h>

#include "test/calibration/synthetic_board.h"

namespace prism {
namespace {

PlenopticCamera Keplerian() {
  PlenopticCamera camera = CameraToCalibrate();
  camera.mode = MicroLensMode::kKeplerian;
  camera.main_lens_mla_distance = camera.focal_length + 2.6 * camera.sensor_mla_distance;
  return camera;
}

PlenopticCamera Distorted() {
  PlenopticCamera camera = CameraToCalibrate();
  camera.distortion = {-200, 1.5e6, 0.02, -0.015};
  return camera;
}

TEST(CameraModel, PointsShowInMicroImagesWhereTheProjectionPutsThem) {
  for (const PlenopticCamera& camera : {CameraToCalibrate(), Keplerian(), Distorted()}) {
    const CameraParameters parameters = ParametersOf(camera);
    const FixedFigures fixed(camera);
    for (const Eigen::Vector3d& x_C : {Eigen::Vector3d(0.05, -0.03, 0.5),
                                       Eigen::Vector3d(-0.3, 0.2, 1.4),
                                       Eigen::Vector3d(0.6, 0.7, 3.1)}) {
      const CornerObservation seen = ObserveExactly(camera, x_C, 0);
      RawAppearance<double> appearance;
      ASSERT_TRUE(Appear(fixed, parameters.data(), x_C, &appearance));
      EXPECT_NEAR(appearance.Slope(0), seen.slope, 1e-12);
      const Eigen::Vector2d px =
          (1 - seen.slope) * appearance.chief_px + seen.slope * seen.micro_image_px;
      // Distortion is taken as linear around x_0: half a micro image away that is good enough.
      EXPECT_LT((px - seen.px).norm(), camera.distortion.IsZero() ? 1e-9 : 0.01)
          << ToString(camera.mode) << " " << x_C.transpose();
    }
  }
}

TEST(CameraModel, ParametersAreThoseOfTheCamera) {
  for (const PlenopticCamera& camera : {CameraToCalibrate(), Keplerian(), Distorted()}) {
    const PlenopticCamera back = WithParameters(PlenopticCamera(camera), ParametersOf(camera));
    EXPECT_NEAR(back.main_lens_mla_distance, camera.main_lens_mla_distance, 1e-15);
    EXPECT_EQ(back.focal_length, camera.focal_length);
    EXPECT_EQ(back.distortion.A1, camera.distortion.A1);
    EXPECT_EQ(back.raw_principal_point, camera.raw_principal_point);
  }
}

TEST(CameraModel, PointsThatHaveNoImageAreRefused) {
  const PlenopticCamera camera = CameraToCalibrate();
  const CameraParameters parameters = ParametersOf(camera);
  RawAppearance<double> appearance;
  const Eigen::Vector3d inside(0, 0, 0.9 * camera.focal_length);
  EXPECT_FALSE(Appear(FixedFigures(camera), parameters.data(), inside, &appearance));
}

}  // namespace
}  // namespace prism
