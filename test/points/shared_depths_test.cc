// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/shared_depths.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prism/factors/default_terms.h"
#include "prism/points/activation.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

TEST(NumSharingDepth, CountsWhatIsCloseTogether) {
  // Two in one place, one five pixels beside them, one far away.
  const std::vector<double> counts = NumSharingDepth({{10, 10}, {10, 10}, {13, 14}, {90, 50}}, 5);
  const double correlation = std::exp(-0.5);
  EXPECT_NEAR(counts[0], 2 + correlation, 1e-12);
  EXPECT_NEAR(counts[1], 2 + correlation, 1e-12);
  EXPECT_NEAR(counts[2], 1 + 2 * correlation, 1e-12);
  EXPECT_EQ(counts[3], 1);
}

TEST(NumSharingDepth, IndependentDepthsStandForThemselves) {
  EXPECT_EQ(NumSharingDepth({{1, 1}, {1, 1}}, 0), (std::vector<double>{1, 1}));
}

// All depths of a keyframe together must not weigh more than the independent ones among them.
TEST(ActivatePoints, DepthsThatShareTheirErrorWeighLess) {
  SyntheticOptions synthetic;
  synthetic.num_keyframes = 1;
  synthetic.num_points = 300;
  const auto information = [&](double correlation_px) {
    Window window = MakeSyntheticWindow(synthetic);
    Keyframe& newest = window.newest();
    auto frame = std::make_shared<LightFieldFrame>(*newest.frame);
    frame->depth_correlation_px = correlation_px;
    const int width = frame->image[0].width(), height = frame->image[0].height();
    frame->inverse_virtual_depth = ImageF(width, height, 0.35f);
    frame->sigma = ImageF(width, height, 0.004f);
    newest.frame = frame;
    newest.points.clear();
    ActivatePoints({}, MakeDefaultTerms({}), 1000, &window);
    double sum = 0;
    for (const auto& point : newest.points) sum += 1 / (point->w_sigma * point->w_sigma);
    return sum * 0.004 * 0.004 / static_cast<double>(newest.points.size());
  };
  EXPECT_NEAR(information(0), 1, 1e-5);
  EXPECT_LT(information(20), 0.3);
}

}  // namespace
}  // namespace prism
