// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/depth_support.h"

#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

constexpr int kSide = 60, kEdge = 30;  // px
constexpr double kSigma = 0.004, kStep = 0.02;

// What lies left of the edge has 1/v smaller by the step.
LightFieldFrame StepFrame(double step, double gross_share = 0) {
  std::mt19937_64 generator = SeededGenerator(3, 0);
  std::normal_distribution<double> noise(0, kSigma);
  std::uniform_real_distribution<double> uniform;
  LightFieldFrame frame;
  frame.inverse_virtual_depth = ImageF(kSide, kSide);
  frame.sigma = ImageF(kSide, kSide, static_cast<float>(kSigma));
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double w = 0.35 - (x < kEdge ? step : 0) + noise(generator);
      if (uniform(generator) < gross_share) w = 0.2 + 0.3 * uniform(generator);
      frame.inverse_virtual_depth(x, y) = static_cast<float>(w);
    }
  }
  return frame;
}

PlenopticProjection Camera() { return PlenopticProjection(SyntheticCamera(SyntheticOptions())); }

// Share of the pixels in columns [first, last) that lie beside something nearer.
double ShareBesideNearer(const PlenopticProjection& camera,
                         const LightFieldFrame& frame,
                         int first,
                         int last) {
  DepthSupport support(camera, frame);
  int beside = 0, all = 0;
  for (int y = 6; y < kSide - 6; ++y) {
    for (int x = first; x < last; ++x, ++all) beside += support.IsBesideNearer(x, y);
  }
  return static_cast<double>(beside) / all;
}

TEST(DepthSupport, APixelBehindAnOutlineIsBesideNearer) {
  const LightFieldFrame frame = StepFrame(kStep);
  EXPECT_GT(ShareBesideNearer(Camera(), frame, kEdge + 1, kEdge + 4), 0.9);
  EXPECT_LT(ShareBesideNearer(Camera(), frame, kEdge - 4, kEdge - 1), 0.1) << "the nearer itself";
  EXPECT_LT(ShareBesideNearer(Camera(), frame, kEdge + 8, kSide - 6), 0.1) << "far from it";
}

TEST(DepthSupport, KnowsNearFromFarInBothModes) {
  PlenopticProjection keplerian = Camera();
  keplerian.B = -keplerian.B;
  const LightFieldFrame frame = StepFrame(kStep);
  EXPECT_LT(ShareBesideNearer(keplerian, frame, kEdge + 1, kEdge + 4), 0.1);
  EXPECT_GT(ShareBesideNearer(keplerian, frame, kEdge - 4, kEdge - 1), 0.9);
}

TEST(DepthSupport, NoiseAndGrossErrorsAreNoOutlines) {
  EXPECT_LT(ShareBesideNearer(Camera(), StepFrame(0), 6, kSide - 6), 0.1);
  EXPECT_LT(ShareBesideNearer(Camera(), StepFrame(0, 0.15), 6, kSide - 6), 0.3);
}

TEST(DepthSupport, WithoutMeasurementsNothingIsKnown) {
  LightFieldFrame frame = StepFrame(kStep);
  frame.sigma = ImageF(kSide, kSide, 0.0f);
  EXPECT_EQ(ShareBesideNearer(Camera(), frame, 0, kSide), 0);
}

}  // namespace
}  // namespace prism
