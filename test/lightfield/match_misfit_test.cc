// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/match_misfit.h"

#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

// Residuals of 6 independent pixels each around what a misfit expects; a share of them is wrong
// matches, three to thirty times as large.
std::vector<MatchSample> Samples(const MatchMisfit& truth, double wrong) {
  std::mt19937_64 generator = SeededGenerator(3, 0);
  std::chi_squared_distribution<float> chi_squared(6);
  std::uniform_real_distribution<float> uniform;
  std::vector<MatchSample> samples;
  for (int i = 0; i < 4000; ++i) {
    const float contrast = 5 * std::exp(4 * uniform(generator));
    const float median_of_chi_squared = 5.35f;
    float residual =
        static_cast<float>(truth.Expect(contrast)) * chi_squared(generator) / median_of_chi_squared;
    if (uniform(generator) < wrong) residual *= 3 + 27 * uniform(generator);
    samples.push_back({contrast, residual});
  }
  return samples;
}

TEST(FitMisfit, FindsNoiseAndShareAmongWrongMatches) {
  for (const MatchMisfit& truth : {MatchMisfit{1, 0.15}, MatchMisfit{1, 0}, MatchMisfit{7, 0.4}}) {
    for (const double wrong : {0.0, 0.25}) {
      const MatchMisfit found = FitMisfit(Samples(truth, wrong));
      EXPECT_NEAR(found.noise / truth.noise, 1, wrong > 0 ? 0.4 : 0.1);
      EXPECT_NEAR(found.share_px, truth.share_px, wrong > 0 ? 0.1 : 0.05);
    }
  }
}

TEST(FitMisfit, FewSamplesTellNothing) {
  const MatchMisfit found = FitMisfit(std::vector<MatchSample>(100, {20, 50}));
  EXPECT_EQ(found.noise, MatchMisfit().noise);
  EXPECT_EQ(found.share_px, MatchMisfit().share_px);
}

}  // namespace
}  // namespace prism
