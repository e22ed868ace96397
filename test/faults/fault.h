// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <cctype>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <ostream>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/io/atomic_file.h"
#include "test/io/rgbd_folder.h"
#include "test/run/raw_folder.h"
#include "test/tools/run_program.h"

namespace prism {

// A row of the matrix: something that goes wrong, and what prism_vo has to make of it.
struct Fault {
  std::string name;
  std::function<void(const std::string& sequence)> inject;
  std::string flags;
  int exit_status = 0;
  std::string message;    // is part of what the program prints
  int unreadable = 0;     // frames
  int min_tracked = 0;    // frames; looked at where the run ends with 0 or 1
  double max_ate_mm = 0;  // against the ground truth; 0: not looked at
};

inline void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

inline std::string FaultName(const testing::TestParamInfo<Fault>& test) {
  std::string name;
  for (const char c : test.param.name) name += std::isalnum(c) != 0 ? c : '_';
  return name;
}

constexpr int kFrames = 12;

// A folder of its own with a sequence as it should be, written once a process and then copied.
inline std::string FreshSequence(const char* kind) {
  namespace fs = std::filesystem;
  const bool is_raw = std::string(kind) == "raw";
  const std::string original = testing::TempDir() + "faults_" + kind + std::to_string(getpid());
  static std::set<std::string> written;
  if (written.insert(kind).second) {
    fs::remove_all(original);
    fs::create_directories(original);
    RgbdFolderOptions options;
    options.num_frames = kFrames;
    is_raw ? WriteRawFolder(original, kFrames) : WriteRgbdFolder(original, options);
    // The frames of this folder are no motion: the camera stands still.
    for (int i = 1; is_raw && i < kFrames; ++i) {
      fs::copy_file(original + "/0.png",
                    original + "/" + std::to_string(i) + ".png",
                    fs::copy_options::overwrite_existing);
    }
  }
  const std::string folder = FreshFolder(kind);
  fs::copy(original, folder, fs::copy_options::recursive);
  return folder;
}

inline std::string CommandFor(const std::string& sequence,
                              const std::string& output,
                              const std::string& flags) {
  const std::string own_camera = sequence + "/camera.yaml";
  const std::string camera = std::filesystem::exists(own_camera)
                                 ? own_camera
                                 : std::string(PRISM_SOURCE_DIR) + "/calib/raytrix_r5_16mm.yaml";
  return "prism_vo --sequence='" + sequence + "' --camera='" + camera + "' --output_dir='" +
         output + "' --threads=1 " + flags;
}

// Runs the program on the sequence with the fault in it, and holds the result against the row.
inline void ExpectFault(const Fault& fault, const std::string& sequence) {
  const std::string output = sequence + "_out";
  std::filesystem::remove_all(output);
  if (fault.inject) fault.inject(sequence);
  const ProgramResult result = RunProgram(CommandFor(sequence, output, fault.flags));
  EXPECT_EQ(result.exit_status, fault.exit_status) << result.output;
  EXPECT_THAT(result.output, testing::HasSubstr(fault.message));
  std::printf("| %s | %d | %s |\n", fault.name.c_str(), result.exit_status, fault.message.c_str());
  if (fault.exit_status == 2) {
    EXPECT_THAT(result.output,
                testing::AllOf(testing::HasSubstr("found"), testing::HasSubstr("expected")));
    EXPECT_FALSE(std::filesystem::exists(output + "/run.json")) << "results of no run";
    return;
  }
  const auto run = nlohmann::json::parse(ReadTextFile(output + "/run.json"));
  EXPECT_EQ(run["end"], "complete");
  EXPECT_EQ(run["unreadable_count"], fault.unreadable);
  int reasons = 0;
  for (const auto& frame : run["frames"]) {
    EXPECT_EQ(frame.contains("reason"), frame["status"] == "unreadable");
    reasons += frame.contains("reason");
  }
  EXPECT_EQ(reasons, fault.unreadable);
  if (fault.unreadable > 0) {
    const std::string last_line = std::to_string(fault.unreadable) + " of " +
                                  std::to_string(run["frames"].size()) +
                                  " frames could not be read (run.json says why)\n";
    EXPECT_THAT(result.output, testing::EndsWith(last_line));
  }
  EXPECT_GE(run["tracked_count"].get<int>(), fault.min_tracked);
  if (fault.max_ate_mm == 0) return;
  const auto metrics = nlohmann::json::parse(ReadTextFile(output + "/metrics.json"));
  EXPECT_LT(1e3 * metrics["ate_rmse_m"].get<double>(), fault.max_ate_mm);
}

}  // namespace prism
