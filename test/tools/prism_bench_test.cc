// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/trajectory_file.h"
#include "test/tools/run_program.h"
#include "tools/bench_process.h"
#include "tools/bench_results.h"
#include "tools/bench_suite.h"

namespace prism {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

// A stand-in for prism_vo: seed 1 kills itself, seed 2 takes too long, seed 3 exits with 1; all
// others leave metrics whose error is that of the flag --error.
const char kFakeProgram[] = R"(#!/bin/bash
for argument in "$@"; do
  case "$argument" in
    --seed=*) seed="${argument#*=}" ;;
    --error=*) error="${argument#*=}" ;;
    --output_dir=*) folder="${argument#*=}" ;;
  esac
done
echo run >> "$folder/../../../calls"
case "$seed" in
  1) kill -9 $$ ;;
  2) sleep 30 ;;
  3) exit 1 ;;
esac
echo "{\"ate_rmse_m\": $error, \"scale\": 1, \"d_s\": 1}" > "$folder/metrics.json"
echo "{\"frames_per_second\": 20, \"stages\": {\"track\": {\"median_ms\": 4}}}" > "$folder/run.json"
)";

const char kSuite[] = R"(
time_limit_s: 0.5
seeds: [0, 1, 2, 3, 4]
sequences:
  - name: kitchen
    flags: {sequence: "{data}/kitchen"}
variants:
  - name: good
    flags: {error: 0.01}
  - name: bad
    flags: {error: 0.5}
)";

const std::string kSuiteOfOne =
    "sequences: [{name: kitchen, flags: {sequence: '{data}/kitchen'}}]\n"
    "variants: [{name: good, flags: {error: 0.01}}]\n";

class PrismBenchTest : public ::testing::Test {
 protected:
  PrismBenchTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("prism_bench_" + std::string(info->name()));
    fs::remove_all(folder_);
    CreateDirectory(folder_.string());
    Write("suite.yaml", kSuite);
    Write("fake.sh", kFakeProgram);
    fs::permissions(Path("fake.sh"), fs::perms::owner_all);
  }
  ~PrismBenchTest() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  void Write(const std::string& name, const std::string& contents) const {
    WriteTextAtomically(Path(name), contents);
  }
  ProgramResult RunBench(const std::string& more) const {
    return RunProgram("prism_bench --suite=" + Path("suite.yaml") + " --program=" +
                      Path("fake.sh") + " --output_dir=" + Path("out") + " " + more);
  }
  std::string SuiteError(const std::string& contents) const {
    Write("bad.yaml", contents);
    try {
      ReadBenchSuite(Path("bad.yaml"), "data");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  size_t Calls() const {
    const std::string calls = ReadTextFile(Path("out/runs/calls"));
    return static_cast<size_t>(std::count(calls.begin(), calls.end(), '\n'));
  }

  fs::path folder_;
};

TEST_F(PrismBenchTest, SurvivesCrashesAndTimeLimitsAndCountsThemAsInfinite) {
  const ProgramResult run = RunBench("");
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const auto results = ReadResults(Path("out/results.jsonl"));
  ASSERT_EQ(results.size(), 10u);
  const char* expected[] = {"done", "crashed", "time limit", "failed", "done"};
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(results[i]["status"], expected[i % 5]) << i;
  EXPECT_NEAR(MetricOf(results[0], "ate_rmse_m"), 0.01, 1e-12);
  EXPECT_TRUE(std::isinf(MetricOf(results[1], "ate_rmse_m")));
  // 3 of 5 runs failed, so the median is infinite.
  EXPECT_THAT(ReadTextFile(Path("out/table.txt")),
              ::testing::ContainsRegex("kitchen/good +5 +3 +inf"));
  for (const char* name : {"cumulative_ate_rmse_m.svg", "cumulative_d_s.png", "report.html"}) {
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
  }
}

TEST_F(PrismBenchTest, TakesUpAStoppedSuiteWhereItWas) {
  RunBench("--job=0");
  RunBench("--job=4");
  EXPECT_EQ(Calls(), 2u);
  const ProgramResult run = RunBench("--filter=good");
  EXPECT_THAT(run.output, HasSubstr("1/5 kitchen/good/0: done (before)"));
  EXPECT_EQ(Calls(), 5u) << "only seeds 1, 2 and 3 were missing";
  RunBench("--filter=good --retry_failed");
  EXPECT_EQ(Calls(), 8u);
}

TEST_F(PrismBenchTest, ComparesWithAnotherSuiteInTableAndPlots) {
  Write("suite.yaml", kSuiteOfOne);
  ASSERT_EQ(RunBench("").exit_status, 0);
  fs::rename(Path("out"), Path("before"));
  std::string worse = kSuiteOfOne;
  worse.replace(worse.find("0.01"), 4, "0.05");
  Write("suite.yaml", worse);
  const ProgramResult run = RunBench("--baseline=" + Path("before"));
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(ReadTextFile(Path("out/table.txt")),
              ::testing::ContainsRegex("kitchen/good +ATE m +0.0100 +0.0100 to 0.0100 +0.0500 +"
                                       "0.0500 to 0.0500 +worse"));
  EXPECT_THAT(ReadTextFile(Path("out/cumulative_ate_rmse_m.svg")), HasSubstr("good (before)\n"));
  EXPECT_THAT(ReadTextFile(Path("out/report.html")), HasSubstr("worse"));
  const ProgramResult nowhere = RunBench("--baseline=" + Path("nowhere"));
  EXPECT_EQ(nowhere.exit_status, 2);
  EXPECT_THAT(nowhere.output, HasSubstr("nowhere/results.jsonl"));
}

TEST_F(PrismBenchTest, TrajectoriesOfOtherSystemsJoinTablesAndPlots) {
  Trajectory truth;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d position(std::sin(0.1 * i), 0.01 * i, std::cos(0.1 * i));
    truth.push_back({i * int64_t{100000000}, SE3(Eigen::Quaterniond::Identity(), position)});
  }
  Trajectory half = truth;
  for (StampedPose& pose : half) {
    pose.world_from_cam =
        SE3(Eigen::Quaterniond::Identity(), 0.5 * pose.world_from_cam.translation());
  }
  CreateDirectory(Path("kitchen"));
  WriteTrajectory(Path("kitchen/groundtruth.txt"), truth);
  WriteTrajectory(Path("half.txt"), half);
  const std::string external =
      "external:\n  - {name: other, sequence: kitchen, trajectory: '{data}/";
  Write("suite.yaml", kSuiteOfOne + external + "half.txt'}\n");
  const ProgramResult run = RunBench("--data_dir=" + folder_.string());
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const auto results = ReadResults(Path("out/results.jsonl"));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_NEAR(MetricOf(results[1], "scale"), 2, 1e-6);
  EXPECT_THAT(ReadTextFile(Path("out/table.txt")), HasSubstr("kitchen/other"));
  EXPECT_THAT(ReadTextFile(Path("out/cumulative_d_s.svg")), HasSubstr("other\n"));

  Write("suite.yaml", kSuiteOfOne + external + "nowhere.txt'}\n");
  fs::remove_all(Path("out"));
  const ProgramResult missing = RunBench("--data_dir=" + folder_.string());
  EXPECT_EQ(missing.exit_status, 2);
  EXPECT_THAT(missing.output, HasSubstr("nowhere.txt"));
  EXPECT_FALSE(fs::exists(Path("out/runs/calls"))) << "it is said before anything runs";
}

TEST_F(PrismBenchTest, ASuiteWithoutASingleSuccessHasFailed) {
  Write("suite.yaml", kSuiteOfOne + "seeds: [3]\n");
  const ProgramResult run = RunBench("");
  EXPECT_EQ(run.exit_status, 1);
  EXPECT_THAT(run.output, HasSubstr("runs/kitchen/good/3/log.txt"));
}

TEST_F(PrismBenchTest, ListsItsJobsByNumber) {
  const ProgramResult run = RunBench("--list_jobs");
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_THAT(run.output, HasSubstr("\n0 kitchen/good/0\n"));
  EXPECT_THAT(run.output, HasSubstr("\n9 kitchen/bad/4\n"));
  EXPECT_EQ(RunBench("--job=10").exit_status, 2);
}

TEST_F(PrismBenchTest, UnknownKeysAreNamedWithTheNearestKnownOne) {
  EXPECT_THAT(SuiteError("sequenzes: []\n"),
              HasSubstr("line 1: found the unknown key 'sequenzes', expected a known one; the "
                        "nearest is 'sequences'"));
  EXPECT_THAT(SuiteError("sequences:\n  - nam: a\n"), HasSubstr("nearest is 'name'"));
  EXPECT_THAT(SuiteError("sequences: [{name: a}, {name: a}]\n"), HasSubstr("'a' twice"));
  EXPECT_THAT(SuiteError("repeats: 3\n"), HasSubstr("no sequence"));
  EXPECT_THAT(SuiteError("time_limit_s: -1\nsequences: [{name: a}]\n"), HasSubstr("time_limit_s"));
  EXPECT_THAT(SuiteError("a: [\n"), HasSubstr("bad.yaml, line"));
}

TEST_F(PrismBenchTest, LaterFlagsHoldAndDataIsReplaced) {
  Write("flags.yaml",
        "flags: {threads: 1, window: 7}\n"
        "sequences: [{name: a, flagfile: a.flags, flags: {sequence: '{data}/a'}}]\n"
        "variants: [{name: v, flags: {window: 4}}]\n");
  const auto jobs = ListJobs(ReadBenchSuite(Path("flags.yaml"), "/d"));
  ASSERT_EQ(jobs.size(), 1u);
  EXPECT_THAT(
      jobs[0].arguments,
      ::testing::ElementsAre(
          "--flagfile=a.flags", "--seed=0", "--sequence=/d/a", "--threads=1", "--window=4"));
}

TEST(BenchResults, ComparisonCallsBetterOnlyWhatLiesOutsideTheSpread) {
  const auto results = [](std::initializer_list<double> errors) {
    std::vector<BenchResult> list;
    for (const double error : errors) {
      list.push_back({{"sequence", "s"}, {"variant", "v"}, {"status", "done"}});
      list.back()["metrics"]["ate_rmse_m"] = error;
    }
    return list;
  };
  const auto now = results({0.1, 0.2, 0.3});
  EXPECT_THAT(FormatComparison(now, results({0.4, 0.5})), HasSubstr("better"));
  EXPECT_THAT(FormatComparison(now, results({0.01, 0.05})), HasSubstr("worse"));
  const std::string same = FormatComparison(now, results({0.25, 0.5}));
  EXPECT_THAT(same, ::testing::Not(HasSubstr("better")));
  EXPECT_THAT(same, ::testing::Not(HasSubstr("worse")));
}

TEST(BenchResults, CumulativePlotCountsRunsAndLeavesOutFailures) {
  std::vector<BenchResult> results;
  for (const double error : {0.3, 0.1}) {
    results.push_back({{"sequence", "s"}, {"variant", "v"}, {"status", "done"}});
    results.back()["metrics"]["ate_rmse_m"] = error;
  }
  results.push_back({{"sequence", "s"}, {"variant", "v"}, {"status", "crashed"}});
  const Plot plot = CumulativePlot(results, "ate_rmse_m", "ATE (m)");
  ASSERT_EQ(plot.series.size(), 1u);
  const auto& points = plot.series[0].points;
  ASSERT_EQ(points.size(), 6u);
  EXPECT_EQ(points[0].x, 0);
  EXPECT_EQ(points[2].x, 0.1);
  EXPECT_EQ(points[2].y, 1);
  EXPECT_EQ(points[5].y, 2) << "the crash never counts";
}

TEST(BenchProcess, EndsWhatTakesTooMuchMemory) {
  const std::string log = ::testing::TempDir() + "/memory_log.txt";
  const ProcessOutcome outcome = RunProcess(
      {"/bin/bash", "-c", "x=$(head -c 300000000 /dev/zero | tr '\\0' x); sleep 20"}, log, 20, 100);
  EXPECT_EQ(outcome.end, ProcessEnd::kMemoryLimit);
  EXPECT_LT(outcome.seconds, 15);
}

TEST(BenchSuite, ShippedSuitesCanBeRead) {
  for (const auto& entry : fs::directory_iterator(std::string(PRISM_SOURCE_DIR) + "/sequences")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_FALSE(ListJobs(ReadBenchSuite(entry.path().string(), "data")).empty()) << entry.path();
  }
}

}  // namespace
}  // namespace prism
