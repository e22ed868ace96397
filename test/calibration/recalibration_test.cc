// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/recalibration.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/map/speckle_texture.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

using ::testing::HasSubstr;

SyntheticOptions Scene() {
  SyntheticOptions options;
  options.width = 320;
  options.height = 240;
  return options;
}

// A walk along a slanted plane; depths spread as the plane's do.
FrameStream Walk(int frames) {
  return [frames, i = 0]() mutable -> std::optional<LightFieldFrame> {
    if (i == frames) return std::nullopt;
    const double s = 0.1 * i;
    const SE3 pose = SE3::Exp((Vector6d() << 0.2 * s,
                               0.05 * std::sin(2 * s),
                               0.1 * s,
                               0.02 * std::sin(s),
                               0.05 * s,
                               0.03 * std::sin(3 * s))
                                  .finished());
    std::mt19937_64 generator = SeededGenerator(77, i);
    std::normal_distribution<double> normal;
    LightFieldFrame frame = *RenderPlane(
        PlenopticProjection(SyntheticCamera(Scene())), pose, 1, &generator, PlaneTexture);
    for (size_t p = 0; p < frame.sigma.size(); ++p) {
      frame.inverse_virtual_depth.data()[p] += static_cast<float>(0.001 * normal(generator));
      frame.sigma.data()[p] = 0.001f;
    }
    frame.time_ns = i++ * int64_t{50'000'000};
    return frame;
  };
}

RecalibrationOptions TestOptions() {
  RecalibrationOptions options;
  options.odometry.window.max_points = 600;
  options.odometry.window.solve.threads = 1;
  return options;
}

TEST(Recalibration, FindsTheDistanceOfTheLensAgain) {
  const PlenopticCamera truth = SyntheticCamera(Scene());
  for (const double wrong_um : {12.0, -12.0}) {
    PlenopticCamera wrong = truth;
    wrong.main_lens_mla_distance += 1e-6 * wrong_um;
    const RecalibrationResult result = Recalibrate(wrong, TestOptions(), [] { return Walk(25); });
    EXPECT_EQ(result.problem, "");
    const double error_um =
        1e6 * (result.camera.main_lens_mla_distance - truth.main_lens_mla_distance);
    EXPECT_LT(std::abs(error_um), 6) << "sigma " << 1e6 * result.sigma_m;
    EXPECT_LT(std::abs(error_um), 3 * 1e6 * result.sigma_m) << "sigma " << 1e6 * result.sigma_m;
    EXPECT_GE(result.passes.size(), 2u);
    EXPECT_EQ(result.camera.focal_length, truth.focal_length);
    EXPECT_EQ(result.camera.sensor_mla_distance, truth.sensor_mla_distance);
  }
}

TEST(Recalibration, FramesThatCannotBeTrackedAreAProblem) {
  const auto blank = [] {
    return [i = 0]() mutable -> std::optional<LightFieldFrame> {
      if (i == 10) return std::nullopt;
      LightFieldFrame frame;
      frame.time_ns = i++ * int64_t{50'000'000};
      frame.image = BuildPyramid(ImageF(320, 240, 0.0f), 6);
      frame.inverse_virtual_depth = ImageF(320, 240, 0.0f);
      frame.sigma = ImageF(320, 240, 0.0f);
      return frame;
    };
  };
  const RecalibrationResult result = Recalibrate(SyntheticCamera(Scene()), TestOptions(), blank);
  EXPECT_THAT(result.problem, HasSubstr("0 of 10 frames"));
}

// Frames that are tracked and tell nothing are not called untracked.
TEST(Recalibration, ACameraThatDoesNotMoveIsAProblem) {
  const auto still = [] {
    return [i = 0]() mutable -> std::optional<LightFieldFrame> {
      if (i == 8) return std::nullopt;
      LightFieldFrame frame = *Walk(1)();
      frame.time_ns = i++ * int64_t{50'000'000};
      return frame;
    };
  };
  const RecalibrationResult result = Recalibrate(SyntheticCamera(Scene()), TestOptions(), still);
  EXPECT_EQ(result.problem,
            "8 of 8 frames were tracked, but they make 1 keyframe, and it takes 2: the camera has "
            "to move");
}

TEST(Recalibration, NoFramesAreAProblem) {
  const auto none = [] { return []() -> std::optional<LightFieldFrame> { return std::nullopt; }; };
  const RecalibrationResult result = Recalibrate(SyntheticCamera(Scene()), TestOptions(), none);
  EXPECT_EQ(result.problem, "no frames");
}

}  // namespace
}  // namespace prism
