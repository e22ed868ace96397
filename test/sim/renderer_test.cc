// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/renderer.h"

#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <Eigen/Cholesky>
#include <opencv2/core.hpp>

#include "prism/sim/sensor.h"
#include "test/sim/test_scene.h"

namespace prism {
namespace {

double InverseVirtualDepthAt(const PlenopticCamera& camera, double z) {
  const double b_L = camera.focal_length * z / (z - camera.focal_length);
  return camera.sensor_mla_distance / (b_L - camera.main_lens_mla_distance);
}

TEST(DepthTruthTest, AFrontoParallelPlaneHasOneInverseVirtualDepth) {
  const PlenopticCamera camera = SmallCamera();
  SimScene scene = WhiteScene();
  AddPatch({0, 0, 1.25}, {4, 0, 0}, {0, 4, 0}, &scene);
  const DepthTruth truth = RenderDepthTruth(RayCaster(scene), camera, SE3());
  const double expected = InverseVirtualDepthAt(camera, 1.25);
  for (int y = 0; y < truth.depth.height(); ++y) {
    for (int x = 0; x < truth.depth.width(); ++x) {
      ASSERT_NEAR(truth.inverse_virtual_depth(x, y), expected, 1e-6) << x << " " << y;
      ASSERT_NEAR(truth.depth(x, y), 1.25, 1e-6);
    }
  }
}

TEST(DepthTruthTest, ASlantedPlaneSeenFromElsewhereFollowsTheClosedForm) {
  const PlenopticCamera camera = SmallCamera();
  SimScene scene = WhiteScene();
  const Eigen::Vector3d on_plane(0.1, -0.2, 2.0);
  const Eigen::Vector3d right(6, 0.5, 3);
  const Eigen::Vector3d down(-0.5, 6, 1);
  AddPatch(on_plane, right, down, &scene);
  Vector6d twist;
  twist << 0.2, -0.1, 0.3, 0.1, -0.15, 0.4;
  const SE3 world_from_cam = SE3::Exp(twist);
  const DepthTruth truth = RenderDepthTruth(RayCaster(scene), camera, world_from_cam);
  // The plane n . x = d in the camera frame.
  const Eigen::Vector3d n = world_from_cam.Inverse().RotationMatrix() * right.cross(down);
  const double d = n.dot(world_from_cam.Inverse() * on_plane);
  const double s = camera.raw_pixel_size * 2;
  const Eigen::Vector2d c = (camera.raw_principal_point.array() + 0.5) / 2 - 0.5;
  for (int y = 0; y < truth.depth.height(); ++y) {
    for (int x = 0; x < truth.depth.width(); ++x) {
      // x_C = ((z - f) m, z), so n.x (z - f) m.x + n.y (z - f) m.y + n.z z = d.
      const double f = camera.focal_length;
      const double k = (n.x() * (x - c.x()) + n.y() * (y - c.y())) * s / f;
      const double z = (d + k * f) / (k + n.z());
      ASSERT_NEAR(truth.inverse_virtual_depth(x, y), InverseVirtualDepthAt(camera, z), 1e-6)
          << x << " " << y << " z " << z;
    }
  }
}

TEST(DepthTruthTest, NothingHitIsZero) {
  SimScene scene = WhiteScene();
  AddPatch({0, 0, -1}, {1, 0, 0}, {0, 1, 0}, &scene);
  const DepthTruth truth = RenderDepthTruth(RayCaster(scene), SmallCamera(), SE3());
  EXPECT_EQ(truth.inverse_virtual_depth(100, 100), 0);
  EXPECT_EQ(truth.depth(100, 100), 0);
}

TEST(RenderTest, DoesNotDependOnTheNumberOfThreadsButOnTheSeed) {
  SimScene scene = WhiteScene();
  AddPatch({0, 0, 1}, {0.3, 0.1, 0}, {0, 0.2, 0}, &scene);
  const RayCaster caster(scene);
  const PlenopticOptics optics(SmallCamera(), OpticsOptions());
  const cv::Mat white = RenderWhite(optics);
  RenderOptions options;
  SensorOptions sensor;
  const auto render = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return ReadSensor(RenderRaw(caster, optics, white, {SE3()}, options, 3), 0.8, sensor, 3);
  };
  const cv::Mat one = render(1);
  EXPECT_EQ(cv::norm(one, render(2), cv::NORM_INF), 0);
  options.seed = 2;
  EXPECT_GT(cv::norm(one, render(2), cv::NORM_INF), 0);
}

// The contrast that is left of a sine pattern says the variance of the blur.
TEST(RenderTest, BlursByThePixelAndTheSpotOfTheMicroLensWhateverTheNumberOfSamples) {
  constexpr double kDepth = 2;          // m
  constexpr int kTexelsAPixel = 8;      // texture texels a raw px
  constexpr int kTexels = 1024;         // a side of the texture
  constexpr int kPeriod = 8;            // raw px
  constexpr double kMaxRadius = 4;      // raw px from the micro-image centre: not shaded
  constexpr double kAmplitude = 100.0;  // of 255
  const PlenopticCamera camera = SmallCamera();
  const PlenopticOptics optics(camera, OpticsOptions());
  cv::Mat sine(kTexels, kTexels, CV_8UC1);
  for (int x = 0; x < kTexels; ++x) {
    const double phase = 2 * M_PI * (x + 0.5) / (kPeriod * kTexelsAPixel);
    sine.col(x).setTo(std::lround(127.5 + kAmplitude * std::sin(phase)));
  }
  SimScene scene;
  scene.textures.emplace_back(sine);
  scene.meshes.emplace_back();
  const double pixel_m = optics.Footprint(kDepth);
  SurfaceStyle style;
  style.texture_size.setConstant(kTexels * pixel_m / kTexelsAPixel);
  AddQuad({-2, -2, kDepth}, {4, 0, 0}, {0, 4, 0}, style, &scene.meshes[0]);
  const RayCaster caster(scene);
  const cv::Mat white = RenderWhite(optics);
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  for (const int samples : {1, 4, 16}) {
    RenderOptions options;
    options.samples = samples;
    const cv::Mat raw = RenderRaw(caster, optics, white, {SE3()}, options, 0);
    for (int type = 0; type < 3; ++type) {
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d moment = Eigen::Vector3d::Zero();
      for (int y = 20; y < raw.rows - 20; ++y) {
        for (int x = 20; x < raw.cols - 20; ++x) {
          const Eigen::Vector2d pixel(x, y);
          const auto lens = optics.LensOf(pixel);
          const LensIndex index = grid.NearestLens(pixel, raw.cols, raw.rows);
          const Eigen::Vector2d center = grid.MicroImageCenter(index, raw.cols, raw.rows);
          PlenopticOptics::Ray ray;
          if (lens.type != type || (pixel - center).norm() > kMaxRadius ||
              !optics.Trace(pixel, lens, {0, 0}, &ray)) {
            continue;
          }
          const double at = ray.origin_xy.x() + kDepth * ray.direction_xy.x();
          const double phase = 2 * M_PI * (at + 2) / (kPeriod * pixel_m);
          const Eigen::Vector3d model(1, std::cos(phase), std::sin(phase));
          normal += model * model.transpose();
          moment += model * raw.at<cv::Vec3f>(y, x)[0] / white.at<float>(y, x);
        }
      }
      const Eigen::Vector3d fit = normal.ldlt().solve(moment);
      const double contrast = fit.tail<2>().norm() * 255 / kAmplitude;
      const double frequency = 2 * M_PI / kPeriod;
      const double variance = -2 * std::log(contrast) / (frequency * frequency);
      const double spot = optics.SpotDiameterAtDepth(type, kDepth);
      const double expected = 1.0 / 12 + spot * spot / 16;
      EXPECT_NEAR(variance, expected, 0.1 * expected) << samples << " samples, type " << type;
    }
  }
}

TEST(RenderTest, MotionDuringTheExposureBlurs) {
  SimScene scene = WhiteScene();
  AddPatch({0, 0, 1}, {0.02, 0, 0}, {0, 0.02, 0}, &scene);
  const RayCaster caster(scene);
  const PlenopticOptics optics(SmallCamera(), OpticsOptions());
  const auto moved = [](double x) { return SE3(Eigen::Quaterniond::Identity(), {x, 0, 0}); };
  const auto lit = [&](const std::vector<SE3>& poses) {
    RenderOptions options;
    options.samples = 16;
    cv::Mat channel;
    cv::extractChannel(
        RenderRaw(caster, optics, RenderWhite(optics), poses, options, 0), channel, 0);
    return cv::countNonZero(channel);
  };
  EXPECT_GT(lit({moved(-0.01), moved(0), moved(0.01)}), 1.3 * lit({moved(0)}));
}

TEST(SensorTest, NoiseHasTheVarianceOfShotAndReadNoise) {
  const cv::Mat radiance(400, 400, CV_32FC1, cv::Scalar(0.5));
  SensorOptions options;
  options.bits = 16;
  options.full_well_electrons = 5000;
  options.read_noise_electrons = 20;
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(ReadSensor(radiance, 1.0, options, 0), mean, sigma);
  EXPECT_NEAR(mean[0] / 65535, 0.5, 2e-4);
  EXPECT_NEAR(sigma[0] / 65535, std::sqrt(0.5 * 5000 + 400) / 5000, 2e-4);
}

TEST(SensorTest, BitsBayerAndClipping) {
  const cv::Mat radiance(4, 4, CV_32FC3, cv::Scalar(0.1, 0.4, 3.0));  // blue, green, red
  SensorOptions options;
  options.full_well_electrons = 0;
  options.colour = SensorColour::kBayerRggb;
  const cv::Mat bayer = ReadSensor(radiance, 1.0, options, 0);
  ASSERT_EQ(bayer.type(), CV_8UC1);
  EXPECT_EQ(bayer.at<uint8_t>(0, 0), 255);
  EXPECT_EQ(bayer.at<uint8_t>(0, 1), 102);
  EXPECT_EQ(bayer.at<uint8_t>(1, 0), 102);
  EXPECT_EQ(bayer.at<uint8_t>(1, 1), 26);
  options.colour = SensorColour::kColour;
  options.bits = 10;
  const cv::Mat colour = ReadSensor(radiance, 1.0, options, 0);
  ASSERT_EQ(colour.type(), CV_16UC3);
  EXPECT_EQ(colour.at<cv::Vec3w>(2, 2)[1], std::lround(std::round(0.4 * 1023) * 65535 / 1023));
}

}  // namespace
}  // namespace prism
