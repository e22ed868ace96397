// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <sys/resource.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/io/atomic_file.h"
#include "prism/io/trajectory_file.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

Trajectory Circle(int count, double radius_m, double start_s = 0) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.02 * i;
    const Eigen::Vector3d position(radius_m * std::cos(angle),
                                   0.3 * radius_m * std::sin(3 * angle),
                                   radius_m * std::sin(angle));
    trajectory.push_back(
        {std::llround(1e9 * (start_s + i / 30.0)), SE3(Eigen::Quaterniond::Identity(), position)});
  }
  return trajectory;
}

// Processor time of all processes this one has waited for: other tests beside it do not count.
double ChildrenSeconds() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

class PrismEvalTest : public ::testing::Test {
 protected:
  PrismEvalTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("prism_eval_" + std::string(info->name()));
    CreateDirectory(folder_.string());
  }
  ~PrismEvalTest() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Write(const std::string& name, const Trajectory& trajectory) const {
    WriteTrajectory(Path(name), trajectory);
    return Path(name);
  }

  fs::path folder_;
};

TEST_F(PrismEvalTest, WritesTableJsonCsvLatexAndPlots) {
  const std::string truth = Write("truth.txt", Circle(300, 1.0));
  const std::string good = Write("good.txt", Circle(300, 1.0));
  const std::string small = Write("small.txt", Circle(300, 0.8));
  const ProgramResult run =
      RunProgram("prism_eval --groundtruth=" + truth + " --estimate=" + good + "," + small +
                 " --json=" + Path("m.json") + " --csv=" + Path("m.csv") +
                 " --latex=" + Path("m.tex") + " --plot_dir=" + Path("plots"));
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("small"));
  const auto json = nlohmann::json::parse(ReadTextFile(Path("m.json")));
  EXPECT_NEAR(json["estimates"][0]["ate_rmse_m"], 0, 1e-8);
  EXPECT_NEAR(json["estimates"][1]["scale"], 1.25, 1e-8);
  for (const char* name : {"trajectory_above", "trajectory_side", "error", "scale"}) {
    EXPECT_TRUE(fs::exists(folder_ / "plots" / (std::string(name) + ".svg"))) << name;
    EXPECT_TRUE(fs::exists(folder_ / "plots" / (std::string(name) + ".png"))) << name;
    EXPECT_TRUE(fs::exists(folder_ / "plots" / (std::string(name) + ".pdf"))) << name;
  }
  EXPECT_TRUE(fs::exists(Path("m.csv")));
  EXPECT_TRUE(fs::exists(Path("m.tex")));
}

TEST_F(PrismEvalTest, PutsTheMetricsOfASingleEstimateAtTheTop) {
  const std::string truth = Write("truth.txt", Circle(300, 1.0));
  const ProgramResult run = RunProgram("prism_eval --groundtruth=" + truth +
                                       " --estimate=" + truth + " --json=" + Path("m.json"));
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NEAR(nlohmann::json::parse(ReadTextFile(Path("m.json")))["ate_rmse_m"], 0, 1e-8);
}

TEST_F(PrismEvalTest, NothingToEvaluateIsStatusOneAndLeavesNothingBehind) {
  const std::string truth = Write("truth.txt", Circle(300, 1.0));
  const std::string later = Write("later.txt", Circle(300, 1.0, 5000));
  const std::string two = Write("two.txt", Circle(2, 1.0));
  for (const std::string& estimate : {later, two}) {
    const ProgramResult run = RunProgram("prism_eval --groundtruth=" + truth +
                                         " --estimate=" + estimate + " --json=" + Path("m.json"));
    EXPECT_EQ(run.exit_status, 1) << run.output;
    EXPECT_THAT(run.output, HasSubstr(estimate + ": found"));
    EXPECT_FALSE(fs::exists(Path("m.json")));
  }
}

TEST_F(PrismEvalTest, BadInputIsStatusTwoWithOneLine) {
  const std::string truth = Write("truth.txt", Circle(300, 1.0));
  WriteTextAtomically(Path("blank.txt"), " \n\n");
  const std::string with_truth = "prism_eval --groundtruth=" + truth;
  const ProgramResult blank = RunProgram(with_truth + " --estimate=" + Path("blank.txt"));
  EXPECT_EQ(blank.exit_status, 2);
  EXPECT_THAT(blank.output, HasSubstr("blank.txt: found no pose, expected"));
  EXPECT_EQ(RunProgram(with_truth).exit_status, 2);
  EXPECT_EQ(RunProgram(with_truth + " --estimate=" + truth + " --no_such_flag").exit_status, 2);
  EXPECT_EQ(RunProgram(with_truth + " --estimate=" + truth + " --label=a,b").exit_status, 2);
  EXPECT_EQ(RunProgram("prism_eval --help").exit_status, 0);
}

TEST_F(PrismEvalTest, BadTrajectoriesAreRefusedWithFileFoundAndExpected) {
  const std::string truth = Write("truth.txt", Circle(300, 1.0));
  const std::string line = "1 0 0 0 0 0 0 1\n";
  const std::pair<std::string, std::string> cases[] = {
      {line + line, "line 2: found the time of the pose before, expected times that increase"},
      {line + "0 0 0 0 0 0 0 1\n", "line 2: found a time before the previous one, expected"},
      {line + "2 0 nan 0 0 0 0 1\n", "line 2: found 'nan', expected"},
      {line + "2 0 0 0 0 0 0 1.2\n", "line 2: found a quaternion of norm 1.2"}};
  for (const auto& [contents, message] : cases) {
    WriteTextAtomically(Path("bad.txt"), contents);
    for (const std::string& files : {"--groundtruth=" + truth + " --estimate=" + Path("bad.txt"),
                                     "--groundtruth=" + Path("bad.txt") + " --estimate=" + truth}) {
      const ProgramResult run = RunProgram("prism_eval " + files + " --json=" + Path("m.json"));
      EXPECT_EQ(run.exit_status, 2) << run.output;
      EXPECT_THAT(run.output, HasSubstr("bad.txt, " + message));
      EXPECT_FALSE(fs::exists(Path("m.json")));
    }
  }
}

TEST_F(PrismEvalTest, QuaternionsNearUnitAreNormalisedWithAWarning) {
  std::string text = FormatTrajectory(Circle(300, 1.0));
  const std::string truth = Write("truth.txt", Circle(300, 1.0));
  text.replace(text.find(" 0 0 0 1\n"), 8, " 0 0 0 1.02");
  WriteTextAtomically(Path("near.txt"), text);
  const ProgramResult run =
      RunProgram("prism_eval --groundtruth=" + truth + " --estimate=" + Path("near.txt") +
                 " --json=" + Path("m.json"));
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("near.txt: 1 rotations were not unit (by up to 0.02)"));
  EXPECT_NEAR(nlohmann::json::parse(ReadTextFile(Path("m.json")))["ate_rmse_m"], 0, 1e-8);
}

TEST_F(PrismEvalTest, EvaluatesAndPlotsAHundredThousandPosesInFourSeconds) {
  const std::string truth = Write("truth.txt", Circle(100000, 1.0));
  const std::string estimate = Write("estimate.txt", Circle(100000, 0.97));
#ifdef __SANITIZE_ADDRESS__  // which slows it down
  constexpr double kMost_s = 20;
#else
  constexpr double kMost_s = 4;
#endif
  const double before_s = ChildrenSeconds();
  const ProgramResult run =
      RunProgram("prism_eval --groundtruth=" + truth + " --estimate=" + estimate +
                 " --json=" + Path("m.json") + " --plot_dir=" + Path("plots"));
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_LT(ChildrenSeconds() - before_s, kMost_s);
}

}  // namespace
}  // namespace prism
