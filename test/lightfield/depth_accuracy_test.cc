// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_accuracy.h"

#include <gtest/gtest.h>

namespace prism {
namespace {

TEST(DepthAccuracy, RanksBySigmaAndCountsOverAllPixelsWithTruth) {
  ImageF depth(20, 10, 0), sigma(20, 10, 0), truth(20, 10, 0.3f);
  for (int i = 0; i < 20; ++i) {  // 10 % of the pixels, certain, 0.002 too large
    depth.data()[i] = 0.302f;
    sigma.data()[i] = 0.002f;
  }
  for (int i = 20; i < 50; ++i) {  // 15 %, uncertain, wrong
    depth.data()[i] = 0.25f;
    sigma.data()[i] = 0.01f;
  }
  DepthAccuracyEvaluator evaluator;
  evaluator.Add(depth, sigma, truth);
  EXPECT_DOUBLE_EQ(evaluator.MeasuredFraction(), 0.25);
  const auto accuracy = evaluator.Evaluate();
  EXPECT_EQ(accuracy[1].pixels, 20);
  EXPECT_NEAR(accuracy[1].median_error, 0.002, 1e-6);
  EXPECT_NEAR(accuracy[1].normalized_sigma, 1.4826, 1e-3);
  EXPECT_EQ(accuracy[1].fraction_above_0_02, 0);
  EXPECT_NEAR(accuracy[2].fraction_above_0_02, 0.6, 1e-9);
  EXPECT_EQ(accuracy[3].pixels, 50);
}

}  // namespace
}  // namespace prism
