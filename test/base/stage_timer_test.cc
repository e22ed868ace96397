// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/stage_timer.h"

#include "prism/base/statistics.h"

#include <gtest/gtest.h>

namespace prism {
namespace {

TEST(StageTimer, SummarizesEachStage) {
  StageTimer timer;
  for (int i = 1; i <= 100; ++i) timer.Add("track", i);
  timer.Add("map", 7);
  const auto summaries = timer.Summarize();
  EXPECT_EQ(summaries.at("track").count, 100);
  EXPECT_EQ(summaries.at("track").median_ms, 50);
  EXPECT_EQ(summaries.at("track").p95_ms, 95);
  EXPECT_EQ(summaries.at("track").total_ms, 5050);
  EXPECT_EQ(summaries.at("map").p95_ms, 7);
}

TEST(Quantile, OfNothingIsZero) { EXPECT_EQ(Quantile({}, 0.5), 0); }

}  // namespace
}  // namespace prism
