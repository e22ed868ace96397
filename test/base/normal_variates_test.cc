// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/normal_variates.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

std::vector<float> Draw(size_t count, uint64_t seed) {
  std::vector<float> values(count);
  NormalVariates(SeededGenerator(seed, 3)).Fill(values.data(), count);
  return values;
}

TEST(NormalVariates, HaveTheNormalDistribution) {
  std::vector<float> values = Draw(1000000, 1);
  double sum = 0, squared = 0, fourth = 0;
  for (const double value : values) {
    sum += value;
    squared += value * value;
    fourth += std::pow(value, 4);
  }
  const double count = static_cast<double>(values.size());
  EXPECT_NEAR(sum / count, 0, 0.004);
  EXPECT_NEAR(squared / count, 1, 0.006);
  EXPECT_NEAR(fourth / count, 3, 0.04);
  // The largest distance of the distribution functions, Kolmogorov's test at 1 %.
  std::sort(values.begin(), values.end());
  double distance = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const double expected = 0.5 * std::erfc(-values[i] / std::sqrt(2));
    distance = std::max(distance, std::abs(expected - static_cast<double>(i) / count));
  }
  EXPECT_LT(distance, 1.63 / std::sqrt(count));
}

TEST(NormalVariates, NeighboursAreIndependent) {
  const std::vector<float> values = Draw(1000000, 2);
  for (const size_t lag : {1, 2, 3, 4, 640}) {
    double product = 0;
    for (size_t i = lag; i < values.size(); ++i) product += values[i] * values[i - lag];
    EXPECT_NEAR(product / static_cast<double>(values.size()), 0, 0.004) << lag;
  }
}

TEST(NormalVariates, DependOnTheGeneratorOnly) {
  EXPECT_EQ(Draw(1001, 5), Draw(1001, 5));
  EXPECT_NE(Draw(1001, 5), Draw(1001, 6));
}

}  // namespace
}  // namespace prism
