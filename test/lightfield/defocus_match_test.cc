// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/defocus_match.h"

#include <gtest/gtest.h>

#include "prism/lightfield/smooth_rows.h"

namespace prism {
namespace {

TEST(DefocusMatch, OneFocalLengthIsUsedAsItIs) {
  const DefocusMatch match({0.3f, 0.3f, 0.3f}, 27, 0.42f);
  for (int type = 0; type < 3; ++type) {
    EXPECT_TRUE(match.Uses(type));
    EXPECT_EQ(match.Blend(type), 0);
  }
}

TEST(DefocusMatch, UsedTypesEndUpEquallyBlurredAndTheFarthestFromFocusIsLeftOut) {
  const std::vector<float> focus = {0.41f, 0.31f, 0.15f};
  constexpr float kVariance = 27;
  for (float w = 0.38f; w < 0.44f; w += 0.01f) {
    const DefocusMatch match(focus, kVariance, w);
    ASSERT_TRUE(match.Uses(0)) << w;
    EXPECT_FALSE(match.Uses(2)) << w;
    if (!match.Uses(1)) continue;
    const auto blurred = [&](int type) {
      return kVariance * (w - focus[type]) * (w - focus[type]) +
             match.Blend(type) * kFilterVariance;
    };
    EXPECT_NEAR(blurred(0), blurred(1), 1e-5) << w;
  }
  EXPECT_TRUE(DefocusMatch(focus, kVariance, 0.4f).Uses(1));
  EXPECT_FALSE(DefocusMatch(focus, kVariance, 0.48f).Uses(1));
}

TEST(DefocusMatch, TheSharpestTypeIsAlwaysUsed) {
  EXPECT_TRUE(DefocusMatch({0.41f, 0.31f, 0.15f}, 27, 0.02f).Uses(2));
  EXPECT_FALSE(DefocusMatch({0.41f, 0.31f, 0.15f}, 27, 0.02f).Uses(0));
}

}  // namespace
}  // namespace prism
