// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/photometric.h"

#include <gtest/gtest.h>

namespace prism {
namespace {

PlenopticCamera TestCamera() {
  PlenopticCamera lens;
  lens.focal_length = 16.748e-3;
  lens.main_lens_mla_distance = 15.893e-3;
  lens.sensor_mla_distance = 0.376e-3;
  return PlenopticFromPinhole({320, 240, 262.5, 262.5, 160, 120}, lens);
}

// Bilinear in x and y, so that the interpolant is the function itself: an analytic image.
ImageF AnalyticImage(int width, int height) {
  ImageF image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = 20 + 0.25f * x + 0.5f * y - x * y / 1024.0f;
  }
  return image;
}

TEST(PhotometricCost, IsZeroForTheSameFrame) {
  const PlenopticProjection camera(TestCamera());
  const ImageF image = AnalyticImage(320, 240);
  PhotometricPatch patch;
  ASSERT_TRUE(MakePatch(image, {100, 80}, &patch));
  FrameState state(SE3::Exp((Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3).finished()), 0.2, 3);
  FramePair pair;
  pair.Update(state, state);
  const PhotometricCost cost(&patch, &pair, image, &camera);
  double rho = 0.5, residuals[8];
  const double* parameters[] = {state.data(), state.data(), &rho};
  ASSERT_TRUE(cost.Evaluate(parameters, residuals, nullptr));
  for (const double r : residuals) EXPECT_NEAR(r, 0, 1e-6);
}

TEST(PhotometricCost, AffineBrightnessExplainsAChangeOfExposure) {
  const PlenopticProjection camera(TestCamera());
  const ImageF host_image = AnalyticImage(320, 240);
  ImageF target_image = host_image;
  const FrameState host(SE3(), 0.1, 2), target(SE3(), -0.15, 7);
  for (size_t i = 0; i < target_image.size(); ++i) {
    const double scene = (host_image.data()[i] - 2) * std::exp(-0.1);
    target_image.data()[i] = static_cast<float>(std::exp(-0.15) * scene + 7);
  }
  PhotometricPatch patch;
  ASSERT_TRUE(MakePatch(host_image, {100, 80}, &patch));
  FramePair pair;
  pair.Update(host, target);
  const PhotometricCost cost(&patch, &pair, target_image, &camera);
  double rho = 0.5, residuals[8];
  const double* parameters[] = {host.data(), target.data(), &rho};
  ASSERT_TRUE(cost.Evaluate(parameters, residuals, nullptr));
  for (const double r : residuals) EXPECT_NEAR(r, 0, 1e-5);
}

TEST(PhotometricCost, OutsideTheImageOrInsideTheFocalLengthIsZero) {
  const PlenopticProjection camera(TestCamera());
  const ImageF image = AnalyticImage(320, 240);
  PhotometricPatch patch;
  ASSERT_TRUE(MakePatch(image, {100, 80}, &patch));
  const FrameState host;
  for (const auto& [shift, rho_value] : {std::pair{5.0, 0.5}, {0.0, 1 / 16e-3}}) {
    const FrameState target(SE3(Eigen::Quaterniond::Identity(), {shift, 0, 0}), 0, 0);
    FramePair pair;
    pair.Update(host, target);
    const PhotometricCost cost(&patch, &pair, image, &camera);
    double rho = rho_value, residuals[8], J0[72], J1[72], J2[8];
    std::fill_n(J0, 72, 1.0);
    const double* parameters[] = {host.data(), target.data(), &rho};
    double* jacobians[] = {J0, J1, J2};
    ASSERT_TRUE(cost.Evaluate(parameters, residuals, jacobians));
    for (const double r : residuals) EXPECT_EQ(r, 0);
    for (const double j : J0) EXPECT_EQ(j, 0);
    for (const double j : J2) EXPECT_EQ(j, 0);
  }
}

TEST(PhotometricCost, FirstEstimatesFixJacobiansOnly) {
  const PlenopticProjection camera(TestCamera());
  const ImageF image = AnalyticImage(320, 240);  // its gradient hardly depends on position
  PhotometricPatch patch;
  ASSERT_TRUE(MakePatch(image, {100, 80}, &patch));
  const FrameState host;
  const FrameState target(SE3::Exp((Vector6d() << 0.02, 0, 0.01, 0, 0.01, 0).finished()), 0, 0);
  const FrameState first(SE3::Exp((Vector6d() << 0.05, 0.02, 0, 0.01, 0, 0).finished()), 0, 0);
  double rho = 0.5;
  const auto evaluate =
      [&](const FrameState* target_first_estimate, double* residuals, double* J2) {
        FramePair pair;
        pair.Update(host, target, nullptr, target_first_estimate);
        const PhotometricCost cost(&patch, &pair, image, &camera);
        const double* parameters[] = {host.data(), target.data(), &rho};
        double* jacobians[] = {nullptr, nullptr, J2};
        ASSERT_TRUE(cost.Evaluate(parameters, residuals, jacobians));
      };
  double r_current[8], r_first[8], J_current[8], J_first[8];
  evaluate(nullptr, r_current, J_current);
  evaluate(&first, r_first, J_first);
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(r_current[k], r_first[k]);
    EXPECT_GT(std::abs(J_current[k] - J_first[k]), 1e-3);
  }
}

TEST(MakePatch, NeedsRoomAroundThePattern) {
  const ImageF image = AnalyticImage(32, 32);
  PhotometricPatch patch;
  EXPECT_FALSE(MakePatch(image, {2, 10}, &patch));
  EXPECT_TRUE(MakePatch(image, {3, 10}, &patch));
  EXPECT_FALSE(MakePatch(image, {29, 10}, &patch));
}

}  // namespace
}  // namespace prism
