// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prism {
namespace {

using testing::HasSubstr;
using testing::Not;

// `measured` pixels of 1000.
ImageF Sigma(int measured) {
  ImageF sigma(100, 10, 0.0f);
  std::fill_n(sigma.data(), measured, 0.004f);
  return sigma;
}

TEST(LightFieldVerdict, TakesMediansOverTheFrames) {
  LightFieldVerdict verdict;
  verdict.Add(Sigma(150), 3, {1, 0.1});
  verdict.Add(Sigma(200), 4, {1.2, 0.15});
  verdict.Add(Sigma(900), 9, {8, 0.6});
  EXPECT_NEAR(verdict.MeasuredFraction(), 0.2, 1e-9);
  EXPECT_EQ(verdict.Noise(), 4);
  EXPECT_EQ(verdict.Misfit().share_px, 0.15);
  EXPECT_TRUE(verdict.IsUsable());
  EXPECT_THAT(verdict.Text(), HasSubstr("depth    at 20.0 % of the pixels (15.0 to 90.0)"));
  EXPECT_THAT(verdict.Text(), Not(HasSubstr("agree")));
}

TEST(LightFieldVerdict, SaysWhatIsLikelyWrong) {
  LightFieldVerdict compressed, wrong_grid, blank;
  compressed.Add(Sigma(400), 3, {6, 0.4});
  EXPECT_THAT(compressed.Text(), HasSubstr("compressed"));
  EXPECT_TRUE(compressed.IsUsable());
  wrong_grid.Add(Sigma(5), 3, {6, 0.7});
  EXPECT_THAT(wrong_grid.Text(), HasSubstr("another camera's grid"));
  EXPECT_FALSE(wrong_grid.IsUsable());
  blank.Add(Sigma(5), 3, {1, 0.1});
  EXPECT_THAT(blank.Text(), HasSubstr("no texture"));
}

}  // namespace
}  // namespace prism
