// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Results survive every end of a run.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "prism/io/trajectory_file.h"
#include "test/faults/fault.h"

namespace prism {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

nlohmann::json ReadRun(const std::string& output) {
  return nlohmann::json::parse(ReadTextFile(output + "/run.json"));
}

// A run of a thousand passes, beside this process and not longer than it; its console goes to
// OUTPUT.log.
class LongRun {
 public:
  LongRun(const std::string& sequence,
          const std::string& output,
          const std::string& flags = "--ping_pong=1000")
      : child_(fork()) {
    if (child_ != 0) return;
    const std::string command = "exec " PRISM_BIN_DIR "/" + CommandFor(sequence, output, flags) +
                                " > '" + output + ".log' 2>&1";
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  ~LongRun() {
    if (child_ > 0) End(SIGKILL);
  }
  LongRun(const LongRun&) = delete;
  LongRun& operator=(const LongRun&) = delete;

  // The status it ended with.
  int End(int signal) {
    int status = 0;
    kill(child_, signal);
    waitpid(child_, &status, 0);
    child_ = 0;
    return status;
  }

 private:
  pid_t child_;
};

bool WaitForFile(const std::string& path, std::chrono::seconds patience) {
  for (const auto end = Clock::now() + patience; Clock::now() < end;) {
    if (fs::exists(path)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

class Ends : public testing::Test {
 protected:
  Ends() : sequence_(FreshSequence("rgbd")), output_(sequence_ + "_out") {
    fs::remove_all(output_);
  }
  std::string sequence_, output_;
};

class EndsBySignal : public Ends, public testing::WithParamInterface<int> {};

TEST_P(EndsBySignal, WithAllWrittenAndMarked) {
  LongRun long_run(sequence_, output_);
  ASSERT_TRUE(WaitForFile(output_ + "/run.json", std::chrono::seconds(60)));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const Clock::time_point begin = Clock::now();
  const int status = long_run.End(GetParam());
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(20));
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 128 + GetParam());
  const nlohmann::json run = ReadRun(output_);
  EXPECT_EQ(run["end"], "interrupted");
  EXPECT_EQ(run["end_reason"], std::string("SIG") + sigabbrev_np(GetParam()));
  EXPECT_EQ(run["frames"].size(), run["frame_count"]);
  EXPECT_EQ(ReadTrajectory(output_ + "/trajectory.txt").size(), run["tracked_count"]);
  for (const char* name : {"keyframes.txt", "points.ply", "metrics.json", "report.html"}) {
    EXPECT_TRUE(fs::exists(output_ + "/" + name)) << name;
  }
  EXPECT_THAT(ReadTextFile(output_ + ".log"), HasSubstr("interrupted by SIG"));
}

TEST_P(EndsBySignal, BeforeTheRunLeaveTheFolderAsItWas) {
  fs::create_directories(output_);
  WriteFile(output_ + "/trajectory.txt", "old");
  const std::string pipe = sequence_ + "/never_written";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  LongRun long_run(sequence_, output_, "--groundtruth=" + pipe);
  // It waits for the ground truth as soon as somebody could write it.
  int writer = -1;
  for (const auto end = Clock::now() + std::chrono::seconds(60);
       writer < 0 && Clock::now() < end;) {
    writer = open(pipe.c_str(), O_WRONLY | O_NONBLOCK);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_GE(writer, 0);
  const int status = long_run.End(GetParam());
  close(writer);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), GetParam());
  EXPECT_EQ(ReadTextFile(output_ + "/trajectory.txt"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(output_), fs::directory_iterator()), 1);
}

INSTANTIATE_TEST_SUITE_P(Signals, EndsBySignal, testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST_F(Ends, ByAKillCostsTheLastTenSeconds) {
  LongRun long_run(sequence_, output_);
  ASSERT_TRUE(WaitForFile(output_ + "/trajectory.txt", std::chrono::seconds(60)));
  std::this_thread::sleep_for(std::chrono::seconds(10));
  long_run.End(SIGKILL);
  EXPECT_EQ(ReadRun(output_)["end"], "running");
  const auto now = fs::file_time_type::clock::now();
  for (const char* name : {"trajectory.txt", "keyframes.txt", "points.ply", "run.json"}) {
    EXPECT_LT(now - fs::last_write_time(output_ + "/" + name), std::chrono::seconds(10)) << name;
  }
  EXPECT_FALSE(ReadTrajectory(output_ + "/trajectory.txt").empty());
}

TEST_F(Ends, OfAnEarlierRunLeaveNothingThatLooksCurrent) {
  fs::create_directories(output_);
  for (const char* name : {"trajectory.txt",
                           "trajectory_segment1.txt",
                           "trajectory_closed.txt",
                           "metrics.json",
                           "report.html",
                           "notes_of_mine.txt"}) {
    WriteFile(output_ + "/" + name, "old");
  }
  const ProgramResult result =
      RunProgram(CommandFor(sequence_, output_, "--max_frames=3 --groundtruth=/dev/null"));
  EXPECT_EQ(result.exit_status, 2) << "it has not begun: all is as it was";
  EXPECT_EQ(ReadTextFile(output_ + "/trajectory.txt"), "old");
  fs::remove(sequence_ + "/groundtruth.txt");
  EXPECT_EQ(RunProgram(CommandFor(sequence_, output_, "--max_frames=3")).exit_status, 0);
  for (const char* name : {"trajectory_segment1.txt", "trajectory_closed.txt", "metrics.json"}) {
    EXPECT_FALSE(fs::exists(output_ + "/" + name)) << name;
  }
  EXPECT_NE(ReadTextFile(output_ + "/trajectory.txt"), "old");
  EXPECT_TRUE(fs::exists(output_ + "/notes_of_mine.txt"));
}

TEST_F(Ends, AFolderThatCannotBeWrittenIsSaidBeforeTheRun) {
  for (const std::string& output : {std::string("/proc/prism"),
                                    sequence_ + "/calibration.txt",
                                    std::string("/sys"),
                                    "/tmp/" + std::string(300, 'n')}) {
    const ProgramResult result = RunProgram(CommandFor(sequence_, output, ""));
    EXPECT_EQ(result.exit_status, 2) << output << result.output;
    EXPECT_THAT(result.output, HasSubstr("expected a folder that can be"));
    EXPECT_THAT(result.output, testing::Not(HasSubstr("frames tracked")));
  }
}

TEST_F(Ends, AFullDiskIsSaidAndWhatFitsIsThere) {
  // Files of this program may have 20 kB: run.json and the cloud do not fit.
  const ProgramResult result =
      RunProgram("prism_vo --version > /dev/null; ulimit -f 20; trap '' XFSZ; exec " +
                 std::string(PRISM_BIN_DIR) + "/" + CommandFor(sequence_, output_, ""));
  EXPECT_EQ(result.exit_status, 2) << result.output;
  EXPECT_THAT(result.output, testing::AllOf(HasSubstr("File too large"), HasSubstr("points.ply")));
  EXPECT_EQ(ReadTrajectory(output_ + "/trajectory.txt").size(), static_cast<size_t>(kFrames));
  for (const auto& entry : fs::directory_iterator(output_)) {
    EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
  }
}

TEST_F(Ends, AConsoleThatGoesAwayEndsNothing) {
  const ProgramResult result = RunProgram(CommandFor(sequence_, output_, "") + " | head -c 1");
  EXPECT_EQ(ReadRun(output_)["end"], "complete") << result.output;
}

TEST_F(Ends, FilesThatAppearUnreadableInMidRunCostFrames) {
  ASSERT_EQ(RunProgram(CommandFor(sequence_, output_, "")).exit_status, 0);
  const std::string whole = ReadTextFile(output_ + "/trajectory.txt");
  WriteFile(sequence_ + "/rgb/000011.png", "");
  ASSERT_EQ(RunProgram(CommandFor(sequence_, output_, "")).exit_status, 0);
  // The frames before it are what they were.
  const std::string part = ReadTextFile(output_ + "/trajectory.txt");
  EXPECT_EQ(ReadTrajectory(output_ + "/trajectory.txt").size(), static_cast<size_t>(kFrames - 1));
  EXPECT_EQ(whole.substr(0, 400), part.substr(0, 400));
}

}  // namespace
}  // namespace prism
