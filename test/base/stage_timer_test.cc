// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/stage_timer.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/statistics.h"

namespace prism {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

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

TEST(StageTimer, QuantilesOfManyCallsAreRightToOnePercent) {
  StageTimer timer;
  std::vector<double> durations_ms;
  for (int i = 0; i < 100000; ++i) {
    durations_ms.push_back(0.002 * std::exp(12 * std::fmod(0.618034 * i, 1.0)));
    timer.Add("track", durations_ms.back());
  }
  const StageTimer::Summary summary = timer.Summarize().at("track");
  EXPECT_EQ(summary.count, 100000);
  for (const auto& [q, found] : {std::pair(0.5, summary.median_ms), {0.95, summary.p95_ms}}) {
    const double expected = Quantile(durations_ms, q);
    EXPECT_NEAR(found, expected, 0.01 * expected);
  }
}

TEST(StageTimer, NewTimesAreThoseSinceTheLastCall) {
  StageTimer timer;
  std::map<std::string, double> totals;
  timer.Add("track", 3);
  timer.Add("map", 7);
  EXPECT_THAT(TakeNewTimes(timer, &totals), ElementsAre(Pair("map", 7), Pair("track", 3)));
  timer.Add("track", 4);
  timer.Add("track", 5);
  EXPECT_THAT(TakeNewTimes(timer, &totals), ElementsAre(Pair("track", 9)));
  EXPECT_THAT(TakeNewTimes(timer, &totals), IsEmpty());
}

TEST(StageTimer, AScopeWithoutATimerTimesNothing) { StageTimer::Scope scope(nullptr, "track"); }

TEST(Quantile, OfNothingIsZero) { EXPECT_EQ(Quantile({}, 0.5), 0); }

}  // namespace
}  // namespace prism
