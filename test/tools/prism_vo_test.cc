// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// End-to-end runs of prism_vo and prism_check_jacobians, as a user starts them.

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/base/version.h"
#include "prism/io/trajectory_file.h"
#include "test/io/rgbd_folder.h"
#include "test/tools/run_bytes.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

std::string Read(const std::string& path) {
  std::ostringstream contents;
  contents << std::ifstream(path).rdbuf();
  return contents.str();
}

nlohmann::json ReadJson(const std::string& path) { return nlohmann::json::parse(Read(path)); }

const std::string kCamera =
    std::string(" --camera=") + PRISM_SOURCE_DIR + "/calib/raytrix_r5_16mm.yaml";

ProgramResult RunVo(const std::string& sequence,
                    const std::string& output,
                    const std::string& flags = "") {
  return RunProgram("prism_vo --sequence=" + sequence + kCamera + " --output_dir=" + output + " " +
                    flags);
}

TEST(PrismVo, TracksARenderedSequenceInMetres) {
  const std::string folder = FreshFolder("run");
  WriteRgbdFolder(folder + "/sequence");
  const ProgramResult result = RunVo(folder + "/sequence", folder + "/out");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const nlohmann::json metrics = ReadJson(folder + "/out/metrics.json");
  EXPECT_EQ(metrics["matched_count"], 20);
  EXPECT_LT(metrics["ate_rmse_m"].get<double>(), 0.004);
  EXPECT_LT(metrics["scale_error_percent"].get<double>(), 2.5);
  EXPECT_GT(metrics["ate_online_rmse_m"].get<double>(), 0);
  const nlohmann::json run = ReadJson(folder + "/out/run.json");
  EXPECT_EQ(run["tracked_count"], 20);
  EXPECT_EQ(run["frames"].size(), 20u);
  EXPECT_GT(run["keyframe_count"].get<int>(), 2);
  EXPECT_EQ(run["version"], kVersion);
  for (const char* key : {"git_hash",
                          "options",
                          "camera",
                          "stages",
                          "wall_seconds",
                          "processor_seconds",
                          "processor_ms_per_frame",
                          "peak_resident_mib",
                          "status",
                          "segments",
                          "variance_factors"}) {
    EXPECT_TRUE(run.contains(key)) << key;
  }
  EXPECT_EQ(run["options"]["seed"], "0");
  for (const char* stage : {"read image", "convert frame", "track"}) {
    EXPECT_GE(run["stages"][stage]["count"].get<int>(), 19) << stage;
    EXPECT_THAT(Read(folder + "/out/report.html"), HasSubstr("\"" + std::string(stage) + "\":"));
  }
  for (const char* name : {"trajectory.txt", "keyframes.txt", "points.ply"}) {
    EXPECT_GT(fs::file_size(folder + "/out/" + name), 100u) << name;
  }
}

std::string DecodeBase64(const std::string& text) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  uint32_t value = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    value = value << 6 | static_cast<uint32_t>(alphabet.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<char>(value >> bits));
  }
  return bytes;
}

// What report.html holds as its data.
nlohmann::json ReportData(const std::string& folder) {
  const std::string page = Read(folder + "/report.html");
  const std::string start = "<script type=\"application/json\" id=\"data\">";
  const size_t begin = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

TEST(PrismVo, TheReportHoldsDepthResidualsScaleAndFusedPoints) {
  const std::string folder = FreshFolder("run");
  WriteRgbdFolder(folder + "/sequence");
  ASSERT_EQ(RunVo(folder + "/sequence", folder + "/out").exit_status, 0);
  const nlohmann::json data = ReportData(folder + "/out");
  const nlohmann::json run = ReadJson(folder + "/out/run.json");
  EXPECT_NEAR(data["scale_sigma"].get<double>(), run["scale_sigma"].get<double>(), 1e-9);
  EXPECT_EQ(data["error"].size(), 20u);
  EXPECT_TRUE(data["left_out"].empty()) << data["left_out"];
  // 12 bytes a point, 4 characters for 3 of them.
  EXPECT_GT(data["dense"]["positions"].get<std::string>().size(), 16 * 1000u);
  size_t stated = 0;
  for (const nlohmann::json& frame : data["frames"]) stated += frame.contains("scale_sigma");
  EXPECT_EQ(stated + 1, run["keyframe_count"].get<size_t>()) << "all but the first";
  ASSERT_EQ(data["keyframes"].size(), run["keyframe_count"].get<size_t>());
  size_t all = 0, fitting = 0;
  for (const nlohmann::json& keyframe : data["keyframes"]) {
    ASSERT_TRUE(keyframe.contains("inverse_virtual_depth") && keyframe.contains("sigma"));
    const nlohmann::json& depth = keyframe["inverse_virtual_depth"];
    EXPECT_GT(depth["low"], 0);
    EXPECT_LT(depth["low"], depth["high"]);
    EXPECT_LT(depth["high"], 0.5);
    EXPECT_NEAR(keyframe["sigma"]["low"].get<double>(), 0.004, 1e-6) << "what was added as noise";
    // x, y, depth and residual, 4 bytes each.
    const std::string bytes = DecodeBase64(keyframe.value("points", ""));
    std::vector<float> points(bytes.size() / sizeof(float));
    if (!bytes.empty()) std::memcpy(points.data(), bytes.data(), bytes.size());
    all += points.size() / 4;
    for (size_t i = 3; i < points.size(); i += 4) fitting += points[i] > 0 && points[i] < 20;
  }
  EXPECT_GT(all, 1000u);
  EXPECT_GT(fitting, all * 8 / 10);
}

TEST(PrismVo, TheSameCommandWritesTheSameBytesWithAnyNumberOfThreads) {
  const std::string folder = FreshFolder("run");
  WriteRgbdFolder(folder + "/sequence");
  const auto bytes_of = [&](const std::string& name, const std::string& flags) {
    EXPECT_EQ(RunVo(folder + "/sequence", folder + "/" + name, flags).exit_status, 0);
    return BytesOfRun(folder + "/" + name);
  };
  const auto bytes = bytes_of("one", "--threads=1 --seed=7");
  EXPECT_EQ(bytes, bytes_of("one_again", "--threads=1 --seed=7"));
  EXPECT_EQ(bytes, bytes_of("two", "--threads=2 --seed=7"));
  EXPECT_EQ(bytes, bytes_of("two_again", "--threads=2 --seed=7"));
  const auto others = bytes_of("other_seed", "--threads=1 --seed=8");
  for (const auto& [name, content] : bytes) EXPECT_NE(content, others.at(name)) << name;
}

TEST(PrismVo, BlackFramesAreNotTrackedAndTheRunGoesOn) {
  const std::string folder = FreshFolder("run");
  RgbdFolderOptions options;
  options.first_black = 8;
  options.last_black = 9;
  WriteRgbdFolder(folder + "/sequence", options);
  const ProgramResult result = RunVo(folder + "/sequence", folder + "/out");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const nlohmann::json run = ReadJson(folder + "/out/run.json");
  EXPECT_EQ(run["tracked_count"], 18);
  EXPECT_EQ(run["frames"][8]["status"], "no texture");
  EXPECT_EQ(run["frames"][10]["status"], "tracked");
  EXPECT_LT(ReadJson(folder + "/out/metrics.json")["ate_rmse_m"].get<double>(), 0.01);
}

TEST(PrismVo, ALiveRunEndsAsAnyOther) {
  const std::string folder = FreshFolder("run");
  RgbdFolderOptions options;
  options.num_frames = 10;
  WriteRgbdFolder(folder + "/sequence", options);
  const std::string port = std::to_string(20000 + getpid() % 20000);
  const ProgramResult result = RunVo(folder + "/sequence", folder + "/out", "--live=" + port);
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_TRUE(fs::exists(folder + "/out/report.html"));
}

TEST(PrismVo, EveryAblationRuns) {
  const std::string folder = FreshFolder("run");
  RgbdFolderOptions options;
  options.num_frames = 10;
  WriteRgbdFolder(folder + "/sequence", options);
  for (const char* flag : {"--depth_residual=false",
                           "--marginalization_prior=false",
                           "--first_estimate_jacobians=false",
                           "--affine_brightness=false",
                           "--robust_loss=false",
                           "--window_keyframes=4 --active_points=500"}) {
    const ProgramResult result = RunVo(folder + "/sequence", folder + "/out", flag);
    EXPECT_EQ(result.exit_status, 0) << flag << result.output;
    EXPECT_LT(ReadJson(folder + "/out/metrics.json")["ate_rmse_m"].get<double>(), 0.02) << flag;
  }
}

TEST(PrismVo, PlaysBackAndForth) {
  const std::string folder = FreshFolder("run");
  RgbdFolderOptions options;
  options.num_frames = 8;
  WriteRgbdFolder(folder + "/sequence", options);
  const ProgramResult result = RunVo(folder + "/sequence", folder + "/out", "--ping_pong=3");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_EQ(ReadJson(folder + "/out/run.json")["frame_count"], 8 + 7 + 7);
  // The ground truth turns with the frames.
  const nlohmann::json metrics = ReadJson(folder + "/out/metrics.json");
  EXPECT_EQ(metrics["matched_count"], 8 + 7 + 7);
  EXPECT_LT(metrics["ate_rmse_m"].get<double>(), 0.01);
}

TEST(PrismVo, PlaysBackwardsWithTheTimesOfTheFile) {
  const std::string folder = FreshFolder("run");
  WriteRgbdFolder(folder + "/sequence");
  ASSERT_EQ(RunVo(folder + "/sequence", folder + "/forwards").exit_status, 0);
  const ProgramResult result = RunVo(folder + "/sequence", folder + "/backwards", "--reverse");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const nlohmann::json metrics = ReadJson(folder + "/backwards/metrics.json");
  EXPECT_EQ(metrics["matched_count"], 20);
  EXPECT_LT(metrics["ate_rmse_m"].get<double>(), 0.01);
  const Trajectory forwards = ReadTrajectory(folder + "/forwards/trajectory.txt");
  const Trajectory backwards = ReadTrajectory(folder + "/backwards/trajectory.txt");
  ASSERT_EQ(forwards.size(), backwards.size());
  for (size_t i = 0; i < forwards.size(); ++i) {
    EXPECT_EQ(forwards[i].time_ns, backwards[i].time_ns);
  }
  // World is the first camera, which is the last one of the file here.
  EXPECT_LT(backwards.back().world_from_cam.translation().norm(), 1e-6);
  EXPECT_GT(backwards.front().world_from_cam.translation().norm(), 0.01);
}

TEST(PrismVo, AMapIsSavedAndALaterRunFindsItselfInIt) {
  const std::string folder = FreshFolder("map");
  WriteRgbdFolder(folder + "/sequence");
  ProgramResult result = RunVo(
      folder + "/sequence", folder + "/first", "--close_loops --save_map=" + folder + "/saved");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, AllOf(HasSubstr("close loops"), HasSubstr("places saved")));
  for (const char* file : {"trajectory_closed.txt", "keyframes_closed.txt", "points_closed.ply"}) {
    EXPECT_TRUE(fs::exists(folder + "/first/" + file)) << file;
  }
  result = RunVo(folder + "/sequence",
                 folder + "/second",
                 "--reverse --map=" + folder + "/saved --save_map=" + folder + "/saved");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const nlohmann::json run = ReadJson(folder + "/second/run.json");
  ASSERT_EQ(run["joins"].size(), 1u) << result.output;
  EXPECT_EQ(run["joins"][0]["piece"], -1);
  EXPECT_EQ(run["segments"][0]["piece"], -1);
  // Both are in the world of the first.
  const Trajectory first = ReadTrajectory(folder + "/first/trajectory.txt");
  const Trajectory second = ReadTrajectory(folder + "/second/trajectory.txt");
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_LT(
        (first[i].world_from_cam.translation() - second[i].world_from_cam.translation()).norm(),
        0.005)
        << "frame " << i;
  }
  EXPECT_EQ(
      RunVo(folder + "/sequence", folder + "/third", "--map=" + folder + "/first").exit_status, 2);
  EXPECT_FALSE(fs::exists(folder + "/third"));
}

TEST(PrismVo, BadInputExitsWithTwoAndLeavesNothingBehind) {
  const std::string folder = FreshFolder("run");
  RgbdFolderOptions options;
  options.num_frames = 3;
  WriteRgbdFolder(folder + "/sequence", options);
  const auto expect_bad = [&](const ProgramResult& result, const std::string& what) {
    EXPECT_EQ(result.exit_status, 2) << result.output;
    EXPECT_THAT(result.output, AllOf(HasSubstr(what), HasSubstr("found"), HasSubstr("expected")));
    EXPECT_FALSE(fs::exists(folder + "/out/trajectory.txt"));
    EXPECT_FALSE(fs::exists(folder + "/out/run.json"));
  };
  const std::string sequence = folder + "/sequence";
  expect_bad(RunProgram("prism_vo"), "--sequence");
  expect_bad(RunVo(folder + "/nowhere", folder + "/out"), "nowhere");
  expect_bad(RunVo(sequence, folder + "/out", "--format=film"), "film");
  expect_bad(RunVo(sequence, folder + "/out", "--pinhole=5"), "--pinhole: found '5'");
  expect_bad(RunVo(sequence, folder + "/out", "--start_frame=9"), "--start_frame");
  expect_bad(RunVo(sequence, folder + "/out", "--window_keyframes=1"), "--window_keyframes");
  expect_bad(RunVo(sequence, folder + "/out", "--export=kitti,film"), "--export: found 'film'");
  WriteFile(folder + "/blank.txt", "  \n");
  expect_bad(RunVo(sequence, folder + "/out", "--groundtruth=" + folder + "/blank.txt"),
             "blank.txt");
  WriteFile(folder + "/camera.yaml", "model: plenoptic\nfocal_length_mm: -3\n");
  expect_bad(RunProgram("prism_vo --sequence=" + sequence + " --camera=" + folder +
                        "/camera.yaml --output_dir=" + folder + "/out"),
             "camera.yaml");
  for (int i = 0; i < 3; ++i) WriteFile(sequence + "/rgb/00000" + std::to_string(i) + ".png", "");
  expect_bad(RunVo(sequence, folder + "/out"), "rgb/000000.png");
  EXPECT_EQ(RunProgram("prism_vo --no_such_flag").exit_status, 2);
}

TEST(PrismVo, HelpTeaches) {
  const ProgramResult result = RunProgram("prism_vo --help");
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("Usage:"), HasSubstr("Example:"), HasSubstr("--depth_residual")));
}

TEST(PrismVo, FlagfilesOfTheProjectAreUnderstood) {
  const std::string folder = FreshFolder("run");
  RgbdFolderOptions options;
  options.num_frames = 2;
  WriteRgbdFolder(folder + "/sequence", options);
  for (const char* name : {"redkitchen", "house_rgbd"}) {
    // --camera in the file is relative to the project's root; the later flag wins.
    const ProgramResult result = RunProgram(
        std::string("prism_vo --flagfile=") + PRISM_SOURCE_DIR + "/sequences/" + name + ".flags" +
        kCamera + " --sequence=" + folder + "/sequence --output_dir=" + folder + "/out");
    EXPECT_EQ(result.exit_status, 0) << result.output;
  }
}

TEST(PrismVo, RedKitchenIsRightInMetres) {
  const std::string sequence = std::string(PRISM_SOURCE_DIR) + "/../shared/data/redkitchen";
  if (!fs::exists(sequence)) GTEST_SKIP() << "the RedKitchen sequence is not here";
  const std::string folder = FreshFolder("run");
  const ProgramResult result = RunVo(
      sequence, folder, "--max_frames=60 --groundtruth=" + sequence + "/groundtruth_reference.txt");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_EQ(ReadJson(folder + "/run.json")["tracked_count"], 60);
  EXPECT_LT(ReadJson(folder + "/metrics.json")["ate_rmse_m"].get<double>(), 0.015);
}

TEST(PrismCheckJacobians, AllBlocksOfAllShippedCamerasAgree) {
  const std::string folder = FreshFolder("run");
  const ProgramResult result =
      RunProgram(std::string("prism_check_jacobians --samples=60 --camera=") + PRISM_SOURCE_DIR +
                 "/calib --json=" + folder + "/jacobians.json");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("all blocks agree"), HasSubstr("(66)"), HasSubstr("(72)")));
  EXPECT_GE(ReadJson(folder + "/jacobians.json").size(), 3u);
}

TEST(PrismCheckJacobians, NeedsACamera) {
  EXPECT_EQ(RunProgram("prism_check_jacobians --camera=/no/such/file.yaml").exit_status, 2);
}

}  // namespace
}  // namespace prism
