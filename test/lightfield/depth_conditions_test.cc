// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_conditions.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prism/camera/projection.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

constexpr double kDepth = 0.3;  // 1/v of the rendered plane

// Conditions at pixels of a plane of this texture. `truth`: kDepth everywhere if empty.
std::vector<DepthConditions> ConditionsOf(const PlenopticCamera& camera,
                                          const VirtualTexture& texture,
                                          const std::vector<Eigen::Vector2i>& pixels,
                                          ImageF truth = {}) {
  LightFieldProcessor processor(camera, {}, {});
  const RawFrame raw{0, "", RenderPlane(camera, kDepth, texture, 0.5)};
  const LightFieldFrame frame = processor.Process(raw);
  if (truth.empty()) {
    truth = ImageF(camera.focused_width(), camera.focused_height(), static_cast<float>(kDepth));
  }
  return MeasureDepthConditions(processor, frame, truth, pixels);
}

// A pattern in the direction of `angle` whose period is `period_px` in a micro image.
VirtualTexture Stripes(double angle, double period_px) {
  return [=](double X, double Y) {
    const double along = X * std::cos(angle) + Y * std::sin(angle);
    return 120 + 60 * std::sin(2 * M_PI * along * kDepth / period_px);
  };
}

TEST(DepthConditions, DistanceAndPlaceAreThoseOfThePixel) {
  const PlenopticCamera camera = SmallCamera();
  const DepthConditions conditions = ConditionsOf(camera, WavyTexture, {{109, 119}})[0];
  EXPECT_FLOAT_EQ(conditions.true_inverse_virtual_depth, kDepth);
  EXPECT_NEAR(
      InverseVirtualDepth(PlenopticProjection(camera), 1 / conditions.distance_m), kDepth, 1e-6);
  EXPECT_NEAR(conditions.image_radius_px, std::hypot(109 - 79.5, 119 - 79.5), 1e-9);
  EXPECT_EQ(conditions.types_used, 1);
  EXPECT_GT(conditions.view_radius_px, conditions.chief_view_radius_px);
  EXPECT_LT(conditions.view_radius_px, 11.6);
  EXPECT_GT(conditions.contrast, 1);
  EXPECT_NEAR(conditions.slant, 0, 1e-6);
}

TEST(DepthConditions, APeriodIsFoundWhereTextureRepeatsItself) {
  std::vector<Eigen::Vector2i> pixels;
  for (int x = 70; x < 90; x += 3) pixels.emplace_back(x, 80);
  for (const DepthConditions& c : ConditionsOf(SmallCamera(), Stripes(0, 7), pixels)) {
    EXPECT_NEAR(c.texture_period_px, 7, 0.6);
  }
  for (const DepthConditions& c : ConditionsOf(SmallCamera(), Stripes(0, 40), pixels)) {
    EXPECT_TRUE(std::isnan(c.texture_period_px)) << c.texture_period_px;
  }
}

TEST(DepthConditions, TheAngleIsThatToTheNearestLensAxis) {
  const std::vector<Eigen::Vector2i> pixels = {{75, 80}, {84, 70}};
  // The axes of this lattice lie at 0, 60 and 120 degrees; it is turned by 0.1 degrees.
  for (const auto& [angle, expected] :
       {std::pair{0.0, 0.0}, {M_PI / 2, 30.0}, {M_PI / 3, 0.0}, {M_PI / 4, 15.0}}) {
    for (const DepthConditions& c : ConditionsOf(SmallCamera(), Stripes(angle, 9), pixels)) {
      EXPECT_NEAR(c.lens_axis_angle_deg, expected, 3) << angle;
    }
  }
}

TEST(DepthConditions, TheSideOfADepthEdgeIsTheSignOfItsDistance) {
  const PlenopticCamera camera = SmallCamera();
  ImageF truth(160, 160, 0.3f);
  for (int y = 0; y < 160; ++y) {
    for (int x = 80; x < 160; ++x) truth(x, y) = 0.25f;  // nearer
  }
  const std::vector<Eigen::Vector2i> pixels = {{70, 60}, {80, 60}, {95, 60}, {30, 60}, {82, 60}};
  const auto conditions = ConditionsOf(camera, WavyTexture, pixels, truth);
  EXPECT_NEAR(conditions[0].depth_edge_distance_px, -9.5, 1e-9);
  EXPECT_NEAR(conditions[1].depth_edge_distance_px, 0.5, 1e-9);
  EXPECT_NEAR(conditions[2].depth_edge_distance_px, 15.5, 1e-9);
  EXPECT_TRUE(std::isnan(conditions[3].depth_edge_distance_px));
  EXPECT_LT(conditions[2].distance_m, conditions[0].distance_m);
  EXPECT_TRUE(std::isnan(conditions[4].slant)) << "across the edge";
  EXPECT_NEAR(conditions[3].slant, 0, 1e-9);
}

TEST(DepthConditions, SlantIsTheGradientOfTheTruth) {
  ImageF truth(160, 160);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 160; ++x) truth(x, y) = 0.3f + 0.0003f * x - 0.0004f * y;
  }
  EXPECT_NEAR(ConditionsOf(SmallCamera(), WavyTexture, {{80, 80}}, truth)[0].slant, 0.0005, 1e-6);
}

TEST(DepthConditions, LensTypesAreThoseSharpAtTheTrueDepth) {
  PlenopticCamera camera = SmallCamera();
  camera.micro_lens_grid->types = {{{0, 0}, 1, 3.2}, {{1, 0}, 2.6, 4.2}, {{-1, 0}, 3.5, 100}};
  ImageF truth(160, 160, 0.42f);
  truth(60, 60) = 0.15f;
  const auto conditions = ConditionsOf(camera, WavyTexture, {{100, 100}, {60, 60}}, truth);
  EXPECT_EQ(conditions[0].sharpest_type, 0);
  EXPECT_EQ(conditions[1].sharpest_type, 2);
  for (const DepthConditions& c : conditions) EXPECT_NE(c.types_used & (1 << c.sharpest_type), 0);
}

}  // namespace
}  // namespace prism
