// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/metrics_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prism {
namespace {

using ::testing::HasSubstr;

std::vector<EvaluatedTrajectory> OneDoneOneFailed() {
  EvaluatedTrajectory done{"a_b,c", "out/a.txt", {}, {}};
  done.metrics.status = EvaluationStatus::kDone;
  done.metrics.matched_count = 228;
  done.metrics.coverage_percent = 100;
  done.metrics.ate_rmse_m = 0.01234;
  done.metrics.segments.resize(2);
  done.metrics.segments[1].matched_count = 77;
  return {done, {"failed", "out/b.txt", {}, {}}};
}

TEST(MetricsTable, TextHasARowAnEstimateAndARowASegment) {
  const std::string text = FormatTextTable(OneDoneOneFailed());
  EXPECT_THAT(text, HasSubstr("0.0123"));
  EXPECT_THAT(text, ::testing::ContainsRegex("segment 2 +77"));
  EXPECT_THAT(text, ::testing::ContainsRegex("failed +0 +0.0 +- +- "));
}

TEST(MetricsTable, CsvQuotesCommasAndLeavesOutWhatIsMissing) {
  const std::string csv = FormatCsv(OneDoneOneFailed());
  EXPECT_THAT(csv, HasSubstr("\n\"a_b,c\",out/a.txt,228,100,0.01234,,"));
  EXPECT_THAT(csv, HasSubstr("\nfailed,out/b.txt,0,0,,,,,,,,,\n"));
}

TEST(MetricsTable, LatexRowsAreEscaped) {
  EXPECT_THAT(FormatLatexRows(OneDoneOneFailed()), HasSubstr("a\\_b,c & 228 & 100.0 & 0.0123"));
}

}  // namespace
}  // namespace prism
