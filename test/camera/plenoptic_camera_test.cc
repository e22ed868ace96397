// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/plenoptic_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prism {
namespace {

PlenopticCamera ValidCamera() {
  PlenopticCamera camera;
  camera.focal_length = 16.748e-3;
  camera.main_lens_mla_distance = 15.893e-3;
  camera.sensor_mla_distance = 0.376e-3;
  camera.raw_width = camera.raw_height = 2048;
  camera.raw_pixel_size = 5.5e-6;
  return camera;
}

TEST(PlenopticCamera, ComplaintsNameTheFigureAndWhatIsExpected) {
  std::string error;
  EXPECT_TRUE(ValidCamera().IsValid(&error));
  PlenopticCamera camera = ValidCamera();
  camera.focal_length = -1e-3;
  EXPECT_FALSE(camera.IsValid(&error));
  EXPECT_EQ(error, "focal length (mm) of -1, expected > 0");
  camera = ValidCamera();
  camera.sensor_mla_distance = std::nan("");
  EXPECT_FALSE(camera.IsValid(&error));
  EXPECT_THAT(error, testing::HasSubstr("sensor to MLA"));
}

TEST(PlenopticCamera, MetricDepthNeedsAFocalLengthOnItsModesSideOfTheMicroLenses) {
  std::string error;
  PlenopticCamera camera = ValidCamera();
  EXPECT_TRUE(camera.HasMetricDepth(&error));
  camera.mode = MicroLensMode::kKeplerian;
  EXPECT_FALSE(camera.HasMetricDepth(&error));
  EXPECT_THAT(error, testing::HasSubstr("of 16.748, expected less than"));
  camera.main_lens_mla_distance = 18e-3;
  EXPECT_TRUE(camera.HasMetricDepth(&error));
  camera.mode = MicroLensMode::kGalilean;
  EXPECT_FALSE(camera.HasMetricDepth(&error));
  EXPECT_THAT(error, testing::HasSubstr("expected more than"));
  EXPECT_THAT(error, testing::HasSubstr("mode: keplerian"));
}

TEST(PinholeCamera, NeedsPositiveFocalLengths) {
  std::string error;
  PinholeCamera camera{640, 480, 525, 525, 320, 240};
  EXPECT_TRUE(camera.IsValid(&error));
  camera.fx = 0;
  EXPECT_FALSE(camera.IsValid(&error));
}

}  // namespace
}  // namespace prism
