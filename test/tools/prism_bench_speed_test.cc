// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/io/atomic_file.h"
#include "test/tools/run_program.h"
#include "tools/bench_process.h"

namespace prism {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// A stand-in for prism_vo that is the faster the more often it was called: 10 frames, at 100 over
// the number of calls milliseconds each.
const char kFakeProgram[] = R"(#!/bin/bash
for argument in "$@"; do
  case "$argument" in
    --fail=*) exit 1 ;;
    --output_dir=*) folder="${argument#*=}" ;;
  esac
done
echo run >> "$folder/../../../calls"
ms=$((100 / $(wc -l < "$folder/../../../calls")))
cat > "$folder/run.json" << END
{"git_hash": "abc", "frame_count": 10, "frames_per_second": $ms, "processor_ms_per_frame": $ms,
 "peak_resident_mib": 50,
 "stages": {"depth": {"count": 10, "median_ms": 7, "p95_ms": 8, "total_ms": 70},
            "track": {"count": 9, "median_ms": $ms, "p95_ms": 9, "total_ms": ${ms}0}}}
END
)";

class PrismBenchSpeed : public ::testing::Test {
 protected:
  PrismBenchSpeed() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("prism_bench_speed_" + std::string(info->name()));
    fs::remove_all(folder_);
    CreateDirectory(folder_.string());
    WriteTextAtomically(Path("fake.sh"), kFakeProgram);
    fs::permissions(Path("fake.sh"), fs::perms::owner_all);
  }
  ~PrismBenchSpeed() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  ProgramResult Measure(const std::string& suite, const std::string& more) const {
    WriteTextAtomically(Path("suite.yaml"), suite);
    return RunProgram("prism_bench --speed --suite=" + Path("suite.yaml") + " --program=" +
                      Path("fake.sh") + " --output_dir=" + Path("out") + " " + more);
  }
  nlohmann::json Results() const {
    return nlohmann::json::parse(ReadTextFile(Path("out/speed.json")));
  }

  fs::path folder_;
};

TEST_F(PrismBenchSpeed, GivesTheSpreadOverTheRunsAfterOneToWarmUp) {
  const ProgramResult run = Measure("seeds: [7, 8]\nsequences: [{name: kitchen}]\n", "--repeat=3");
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const nlohmann::json results = Results();
  for (const char* key : {"processor", "cores", "compiler", "build_type", "load_before"}) {
    EXPECT_TRUE(results["machine"].contains(key)) << key;
  }
  ASSERT_EQ(results["runs"].size(), 1u) << "of the first seed alone";
  const nlohmann::json& summary = results["runs"][0];
  EXPECT_THAT(summary["command"].dump(), HasSubstr("--seed=7"));
  EXPECT_EQ(summary["git_hash"], "abc");
  EXPECT_EQ(summary["runs"], 3);
  EXPECT_EQ(summary["frames"], 10);
  const nlohmann::json expected = {{"min", 25.0}, {"median", 33.0}, {"max", 50.0}};
  EXPECT_EQ(summary["processor_ms_per_frame"], expected) << "that of 100 was to warm up";
  EXPECT_EQ(summary["stages"]["track"]["ms_per_call"], expected);
  EXPECT_EQ(summary["stages"]["track"]["ms_per_frame"], expected);
  EXPECT_EQ(summary["stages"]["depth"]["calls"], 10);
  const std::string table = ReadTextFile(Path("out/speed.txt"));
  EXPECT_THAT(run.output, HasSubstr(table));
  EXPECT_THAT(table, ContainsRegex("processor ms a frame +25.0 +33.0 +50.0"));
  EXPECT_THAT(table, ContainsRegex("track +9 +25.00 +33.00 +50.00 +25.00 +33.00 +50.00"));
  EXPECT_LT(table.find("\ntrack"), table.find("\ndepth")) << "what takes most stands first";
}

TEST_F(PrismBenchSpeed, ARunThatFailsIsNamedAndTheOthersAreMeasured) {
  const ProgramResult run =
      Measure("sequences: [{name: bad, flags: {fail: 1}}, {name: good}]\n", "--repeat=1");
  EXPECT_EQ(run.exit_status, 1);
  EXPECT_THAT(run.output, HasSubstr("runs/bad/default/0/log.txt"));
  ASSERT_EQ(Results()["runs"].size(), 1u);
  EXPECT_EQ(Results()["runs"][0]["sequence"], "good");
}

TEST_F(PrismBenchSpeed, JobAndBaselineMeanNothingHere) {
  EXPECT_EQ(Measure("sequences: [{name: kitchen}]\n", "--job=0").exit_status, 2);
  EXPECT_EQ(Measure("sequences: [{name: kitchen}]\n", "--baseline=x").exit_status, 2);
}

TEST(BenchProcess, MeasuresTheProgramAlone) {
  const ProcessOutcome outcome =
      RunProcess({"/bin/bash", "-c", "for ((i = 0; i < 300000; ++i)); do :; done"},
                 ::testing::TempDir() + "/processor_log.txt",
                 60,
                 1000);
  EXPECT_EQ(outcome.end, ProcessEnd::kExited);
  EXPECT_GT(outcome.processor_seconds, 0.02);
  EXPECT_LT(outcome.processor_seconds, outcome.seconds + 0.1);
  EXPECT_GT(outcome.instructions.value_or(1e9), 1e7);  // most virtual machines do not count
}

}  // namespace
}  // namespace prism
