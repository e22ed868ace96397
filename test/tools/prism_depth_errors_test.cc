// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "test/lightfield/synthetic_frame.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr double kDepth = 0.3;    // 1/v that is rendered
constexpr double kOffset = 0.01;  // by which the truth that is told is smaller

// A raw sequence of three frames of a plane, the first and the last of them with truth.
class PrismDepthErrorsTest : public ::testing::Test {
 protected:
  PrismDepthErrorsTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("prism_depth_errors_" + std::string(info->name()));
    fs::remove_all(folder_);
    const PlenopticCamera camera = SmallCamera();
    CreateDirectory(Path("virtual_depth_truth"));
    WriteNativeCamera(Path("camera.yaml"), camera);
    WriteTextAtomically(Path("raw.txt"), "0.1 0.png\n0.2 1.png\n0.3 2.png\n");
    for (int i = 0; i < 3; ++i) {
      const auto texture = [i](double X, double Y) { return WavyTexture(X + 40 * i, Y); };
      cv::imwrite(Path(std::to_string(i) + ".png"), RenderPlane(camera, kDepth, texture, 1));
    }
    const double value = 65535 * (1 - (kDepth - kOffset));
    const cv::Mat truth(160, 160, CV_16UC1, cv::Scalar(value));
    for (const char* name : {"000000.png", "000002.png"}) {
      cv::imwrite(Path(std::string("virtual_depth_truth/") + name), truth);
    }
  }
  ~PrismDepthErrorsTest() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  ProgramResult Run(const std::string& flags = "") const {
    return RunProgram("prism_depth_errors --raw=" + folder_.string() +
                      " --output_dir=" + Path("out") + " " + flags);
  }
  nlohmann::json Results() const {
    return nlohmann::json::parse(ReadTextFile(Path("out/depth_errors.json")));
  }

  fs::path folder_;
};

TEST_F(PrismDepthErrorsTest, AnErrorOfAllDepthsIsFoundInEachFrameWithTruth) {
  const ProgramResult run = Run();
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const nlohmann::json json = Results();
  const nlohmann::json& frames = json["sequences"][0]["frames"];
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1]["frame"], 2);
  for (const nlohmann::json& frame : frames) {
    EXPECT_GT(frame["points"], 50);
    EXPECT_NEAR(frame["median"].get<double>(), kOffset, 0.003);
  }
  EXPECT_EQ(json["frame_to_frame"]["frames"], 2);
  EXPECT_EQ(json["features"]["stated_sigma"]["bins"].size(), 3u);
  EXPECT_FALSE(json["features"].contains("lens_types_used")) << "there is one type";
  EXPECT_THAT(run.output, HasSubstr("stated standard deviation"));
  EXPECT_THAT(ReadTextFile(Path("out/depth_errors.svg")), HasSubstr("distance from the image"));
  EXPECT_TRUE(fs::exists(Path("out/depth_errors.png")));
}

TEST_F(PrismDepthErrorsTest, ResultsDoNotDependOnThreads) {
  ASSERT_EQ(Run("--threads=1").exit_status, 0);
  const nlohmann::json one = Results();
  ASSERT_EQ(Run("--threads=2").exit_status, 0);
  EXPECT_EQ(one["features"], Results()["features"]);
}

TEST_F(PrismDepthErrorsTest, MissingTruthAndCameraAreBadInput) {
  ProgramResult run = Run("--truth=nowhere");
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_THAT(run.output, HasSubstr("nowhere: found no such folder"));
  CreateDirectory(Path("empty"));
  run = Run("--truth=empty");
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_THAT(run.output, HasSubstr("empty: found no truth of any frame"));
  fs::remove(Path("camera.yaml"));
  run = Run();
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("--camera"), HasSubstr("camera.yaml is missing")));
  EXPECT_FALSE(fs::exists(Path("out")));
}

}  // namespace
}  // namespace prism
