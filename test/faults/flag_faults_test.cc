// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Flags of prism_vo at their limits and beyond, and suites of prism_bench.
#include <string>
#include <vector>

#include "test/faults/fault.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(FlagFaults, AreRefusedBeforeTheRun) {
  const std::string sequence = FreshSequence("rgbd");
  const std::vector<Fault> faults = {
      {"threads 1e9", nullptr, "--threads=1000000000", 2, "--threads"},
      {"threads -1", nullptr, "--threads=-1", 2, "--threads"},
      {"ping pong 1e9", nullptr, "--ping_pong=1000000000", 2, "--ping_pong"},
      {"ping pong -1", nullptr, "--ping_pong=-1", 2, "--ping_pong"},
      {"max frames -5", nullptr, "--max_frames=-5", 2, "--max_frames"},
      {"start frame -1", nullptr, "--start_frame=-1", 2, "--start_frame"},
      {"start frame behind the end", nullptr, "--start_frame=12", 2, "--start_frame"},
      {"window of none", nullptr, "--window_keyframes=0", 2, "--window_keyframes: found "},
      {"window of 2e9", nullptr, "--window_keyframes=2000000000", 2, "--window_keyframes: found "},
      {"no points", nullptr, "--active_points=0", 2, "--active_points: found "},
      {"points -1", nullptr, "--active_points=-1", 2, "--active_points: found "},
      {"points 2e9", nullptr, "--active_points=2000000000", 2, "--active_points: found "},
      {"iterations 0", nullptr, "--iterations=0", 2, "--iterations: found "},
      {"iterations 1e9", nullptr, "--iterations=1000000000", 2, "--iterations: found "},
      {"sigma NaN",
       nullptr,
       "--photometric_model_sigma=nan",
       2,
       "--photometric_model_sigma: found "},
      {"sigma infinite",
       nullptr,
       "--photometric_model_sigma=inf",
       2,
       "--photometric_model_sigma: found "},
      {"sigma 1e300",
       nullptr,
       "--photometric_model_sigma=1e300",
       2,
       "--photometric_model_sigma: found "},
      {"sigma -1", nullptr, "--photometric_model_sigma=-1", 2, "--photometric_model_sigma: found "},
      {"sigma 0", nullptr, "--photometric_model_sigma=0", 2, "--photometric_model_sigma: found "},
      {"depth noise NaN",
       nullptr,
       "--rgbd_inverse_depth_sigma=nan",
       2,
       "--rgbd_inverse_depth_sigma: found "},
      {"depth noise -1",
       nullptr,
       "--rgbd_inverse_depth_sigma=-1",
       2,
       "--rgbd_inverse_depth_sigma: found "},
      {"depth noise 1e9",
       nullptr,
       "--rgbd_inverse_depth_sigma=1e9",
       2,
       "--rgbd_inverse_depth_sigma: found "},
      {"offset NaN", nullptr, "--depth_offset_sigma=nan", 2, "--depth_offset_sigma: found "},
      {"offset infinite", nullptr, "--depth_offset_sigma=inf", 2, "--depth_offset_sigma: found "},
      {"offset -1", nullptr, "--depth_offset_sigma=-1", 2, "--depth_offset_sigma: found "},
      {"places -1", nullptr, "--map_places=-1", 2, "--map_places: found "},
      {"places 0", nullptr, "--map_places=0", 2, "--map_places: found "},
      {"port 70000", nullptr, "--live=70000", 2, "--live"},
      {"port -1", nullptr, "--live=-1", 2, "--live"},
      {"format", nullptr, "--format=film", 2, "'film'"},
      {"colour", nullptr, "--colour=sepia", 2, "'sepia'"},
      {"no such map", nullptr, "--map=/no/such/map", 2, "/no/such/map"},
      {"no such ground truth", nullptr, "--groundtruth=/no/such/file", 2, "/no/such/file"},
  };
  for (const Fault& fault : faults) {
    SCOPED_TRACE(fault.name);
    ExpectFault(fault, sequence);
  }
}

TEST(FlagFaults, WhatTheCommandLineRefusesItself) {
  for (const char* flags : {"--no_such_flag",
                            "--threads=many",
                            "--threads=99999999999",
                            "a word",
                            "--reverse=perhaps"}) {
    EXPECT_EQ(RunProgram(std::string("prism_vo ") + flags).exit_status, 2) << flags;
  }
}

TEST(FlagFaults, VersionAndDefaultsAreAsPeopleWriteThem) {
  EXPECT_THAT(RunProgram("prism_vo --version").output, HasSubstr("prism_vo "));
  const ProgramResult help = RunProgram("prism_vo --help");
  EXPECT_THAT(help.output, HasSubstr("--rgbd_inverse_depth_sigma=0.004 "));
  EXPECT_THAT(RunProgram("prism_vo").output, HasSubstr("--rgbd_inverse_depth_sigma=0.004 "));
}

TEST(FlagFaults, OfSuitesAreNamed) {
  const std::string folder = FreshFolder("suites");
  const std::string sequences = "sequences:\n  - {name: a, flags: {sequence: /tmp}}\n";
  struct SuiteFault {
    std::string text, named;
  };
  const std::vector<SuiteFault> faults = {
      {sequences + "seeds: [1, x]\n", "a bad seed"},
      {sequences + "seeds: x\n", "no seeds"},
      {sequences + "seeds: [-1]\n", "a bad seed"},
      {sequences + "? [a, b]\n: 3\n", "a list or map as a key"},
      {sequences + "repeats: 1e12\n", "a bad 'repeats'"},
      {sequences + "repeats: 0\n", "a bad 'repeats'"},
      {sequences + "repeats: .nan\n", "a bad 'repeats'"},
      {sequences + "memory_limit_mib: 1e300\n", "a bad 'memory_limit_mib'"},
      {sequences + "time_limit_s: -1\n", "a bad 'time_limit_s'"},
      {sequences + sequences, "the key 'sequences' twice"},
      {"sequences:\n  - {name: ..}\n", "the name '..'"},
      {"sequences:\n  - {name: a/b}\n", "the name 'a/b'"},
      {"sequences:\n  - {name: " + std::string(300, 'n') + "}\n", "the name 'nnn"},
      {"sequences:\n  - {name: a, flags: {? [x] : 3}}\n", "a list or map as a key"},
      {"sequences:\n  - {name: a, flags: {x: [1]}}\n", "no value"},
      {"sequences:\n  - {name: a, flags: 7}\n", "flags that are no map"},
      {"sequences: 3\n", ""},
      {"sequences:\n  - 3\n", "no keys"},
      {"variants:\n  - {name: x}\n", "no sequence"},
      {"", "no keys"},
      {"[[[", "suite.yaml"},
  };
  for (const SuiteFault& fault : faults) {
    WriteFile(folder + "/suite.yaml", fault.text);
    const ProgramResult result = RunProgram("prism_bench --list_jobs --suite=" + folder +
                                            "/suite.yaml --output_dir=" + folder + "/out");
    EXPECT_EQ(result.exit_status, 2) << fault.text << result.output;
    EXPECT_THAT(result.output, AllOf(HasSubstr("suite.yaml"), HasSubstr(fault.named)))
        << fault.text;
  }
}

TEST(FlagFaults, OfTrajectoriesAreNamed) {
  const std::string folder = FreshFolder("trajectories");
  const std::string pose = " 0 0 0 0 0 0 1\n";
  WriteFile(folder + "/good.txt", "0" + pose + "1" + pose + "2" + pose);
  for (const std::string& text : {std::string("0 1 2\n"),
                                  "x" + pose,
                                  "nan" + pose,
                                  "0" + pose + "0" + pose,
                                  "1" + pose + "0" + pose,
                                  std::string("0 0 0 0 0 0 0 0\n"),
                                  "1e300" + pose,
                                  std::string(1 << 20, '7') + "\n",
                                  std::string("0,0,0\n"),
                                  std::string(""),
                                  std::string("\0\n", 2)}) {
    WriteFile(folder + "/bad.txt", text);
    const ProgramResult result = RunProgram("prism_eval --groundtruth=" + folder +
                                            "/good.txt --estimate=" + folder + "/bad.txt");
    EXPECT_EQ(result.exit_status, 2) << text.substr(0, 50) << result.output;
    EXPECT_THAT(result.output, AllOf(HasSubstr("bad.txt"), HasSubstr("expected")));
    EXPECT_LT(result.output.size(), 4000u);
  }
}

}  // namespace
}  // namespace prism
