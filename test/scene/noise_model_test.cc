// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/scene/noise_model.h"

#include <gtest/gtest.h>

namespace prism {
namespace {

TEST(NoiseModel, StandardDeviationsFollowTheVarianceFactorsSlowly) {
  NoiseModel noise(2, 3.5);
  const double stated = noise.ResidualSigma();
  // Residuals of images twice as large as stated, of depths half as large: what a window says
  // depends on what it is told.
  const auto observe = [&] {
    const double photometric = 2 * stated / noise.ResidualSigma(), depth = 0.5 / noise.DepthScale();
    noise.ObserveWindow(photometric * photometric, depth * depth);
  };
  observe();
  EXPECT_LT(noise.ResidualSigma(), 1.1 * stated);
  for (int i = 0; i < 60; ++i) observe();
  EXPECT_NEAR(noise.ResidualSigma(), 2 * stated, 0.02 * stated);
  EXPECT_NEAR(noise.DepthScale(), 0.5, 0.005);
}

TEST(NoiseModel, AWindowThatSaysNothingChangesNothing) {
  NoiseModel noise(2, 3.5);
  const double stated = noise.ResidualSigma();
  noise.ObserveWindow(0, 0);
  EXPECT_EQ(noise.ResidualSigma(), stated);
  EXPECT_EQ(noise.DepthScale(), 1);
}

TEST(NoiseModel, TheSigmaOfDepthOffsetsFollowsTheMeanSquare) {
  NoiseModel noise(2, 3.5);
  for (int i = 0; i < 100; ++i) noise.ObserveDepthOffsets((i % 2 == 0 ? 0.1 : 1.9) * 1e-6);
  EXPECT_NEAR(noise.DepthOffsetSigma(), 1e-3, 1e-4);
}

TEST(NoiseModel, WhatIsUsualFollowsAgreementThatFallsFromFrameToFrame) {
  NoiseModel noise(2, 3.5);
  for (int i = 0; i < 20; ++i) noise.ObserveDepthAgreement(0.9);
  for (int i = 0; i < 5; ++i) noise.ObserveDepthAgreement(0.7);
  EXPECT_EQ(noise.UsualDepthAgreement(), 0.7);
}

TEST(NoiseModel, OneBadFrameDoesNotChangeWhatIsUsual) {
  NoiseModel noise(2, 3.5);
  for (int i = 0; i < 5; ++i) {
    noise.Observe(10);
    noise.ObserveDepthAgreement(0.9);
  }
  noise.Observe(50);
  noise.ObserveDepthAgreement(0.1);
  EXPECT_NEAR(noise.FitSigma(), 10, 1e-9);
  EXPECT_EQ(noise.UsualDepthAgreement(), 0.9);
}

}  // namespace
}  // namespace prism
