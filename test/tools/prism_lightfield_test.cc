// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/version.h"
#include "prism/camera/projection.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "test/lightfield/synthetic_frame.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// A folder of one raw frame with its white image and camera, for each test to spoil.
class PrismLightfieldTest : public ::testing::Test {
 protected:
  PrismLightfieldTest() : camera_(SmallCamera()) {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("prism_lightfield_" + std::string(info->name()));
    CreateDirectory(folder_.string());
    WriteTextAtomically(Path("raw.txt"), "0.1 frame.png\n");
    cv::imwrite(Path("frame.png"), RenderPlane(camera_, 0.3, WavyTexture, 1, true));
    cv::imwrite(Path("white.png"),
                RenderPlane(
                    camera_, 0.3, [](double, double) { return 200; }, 1, true));
    WriteNativeCamera(Path("camera.yaml"), camera_);
  }
  ~PrismLightfieldTest() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  ProgramResult Run(const std::string& flags = "") const {
    return RunProgram("prism_lightfield --raw=" + folder_.string() + " --camera=" +
                      Path("camera.yaml") + " --output_dir=" + Path("out") + " " + flags);
  }
  void WriteCameraWithPitch(double pitch_px) const {
    PlenopticCamera camera = camera_;
    camera.micro_lens_grid->diameter_px = pitch_px;
    WriteNativeCamera(Path("camera.yaml"), camera);
  }

  PlenopticCamera camera_;
  fs::path folder_;
};

TEST_F(PrismLightfieldTest, RefinesTheGridAndSaysHow) {
  const ProgramResult result = Run();
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("refined on the white image"));
  fs::remove(Path("white.png"));
  PlenopticCamera moved = camera_;
  moved.micro_lens_grid->offset_px += Eigen::Vector2d(1.5, -1);
  WriteNativeCamera(Path("camera.yaml"), moved);
  const ProgramResult without_white = Run();
  EXPECT_EQ(without_white.exit_status, 0) << without_white.output;
  EXPECT_THAT(without_white.output, HasSubstr("refined on the raw frames"));
}

TEST_F(PrismLightfieldTest, TakesTheCameraOfTheFolder) {
  const std::string command =
      "prism_lightfield --raw=" + folder_.string() + " --output_dir=" + Path("out");
  const ProgramResult result = RunProgram(command);
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("camera: camera.yaml of the folder"));
  fs::remove(Path("camera.yaml"));
  const ProgramResult without = RunProgram(command);
  EXPECT_EQ(without.exit_status, 2);
  EXPECT_THAT(without.output, HasSubstr("found neither camera.yaml nor CameraModel.xml"));
}

TEST_F(PrismLightfieldTest, SaysWhichVersionWroteTheResults) {
  ASSERT_EQ(Run("--threads=0").exit_status, 0);
  const auto json = nlohmann::json::parse(ReadTextFile(Path("out/lightfield.json")));
  EXPECT_EQ(json["version"], kVersion);
  EXPECT_NE(json["git_hash"], "");
}

TEST_F(PrismLightfieldTest, DepthIsWrittenInMetresIfAskedFor) {
  ASSERT_EQ(Run().exit_status, 0);
  EXPECT_FALSE(fs::exists(Path("out/depth_m")));
  ASSERT_EQ(Run("--depth_tiff").exit_status, 0);
  const cv::Mat depth = cv::imread(Path("out/depth_m/000000.tif"), cv::IMREAD_UNCHANGED);
  const cv::Mat encoded =
      cv::imread(Path("out/inverse_virtual_depth/000000.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_32FC1);
  ASSERT_EQ(depth.size(), encoded.size());
  const PlenopticProjection projection(ReadPlenopticCamera(Path("out/camera.yaml")));
  int measured = 0;
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const int value = encoded.at<uint16_t>(y, x);
      ASSERT_EQ(depth.at<float>(y, x) > 0, value > 0) << x << ", " << y;
      if (value == 0) continue;
      ++measured;
      EXPECT_NEAR(1 / depth.at<float>(y, x), InverseDepth(projection, 1 - value / 65535.0), 0.01);
    }
  }
  EXPECT_GT(measured, 1000);
}

TEST_F(PrismLightfieldTest, ANegativeNumberOfThreadsIsBadInput) {
  const ProgramResult result = Run("--threads=-1");
  EXPECT_EQ(result.exit_status, 2) << result.output;
  EXPECT_THAT(result.output, HasSubstr("--threads: found -1, expected 0 (one a core) to 1024"));
}

TEST_F(PrismLightfieldTest, AGridOfAnotherPitchThanTheWhiteImageIsBadInput) {
  for (const double pitch_px : {23.4, 24.0, 28.0}) {
    WriteCameraWithPitch(pitch_px);
    const ProgramResult result = Run();
    EXPECT_EQ(result.exit_status, 2) << result.output;
    EXPECT_THAT(result.output,
                AllOf(HasSubstr("camera.yaml: found a micro-lens pitch of " +
                                std::to_string(pitch_px).substr(0, 7)),
                      HasSubstr("expected 23.2"),
                      HasSubstr("pitch of the white image")));
  }
}

TEST_F(PrismLightfieldTest, ABlackWhiteImageIsBadInput) {
  cv::imwrite(Path("white.png"), cv::Mat(320, 320, CV_8UC1, cv::Scalar(0)));
  const ProgramResult result = Run();
  EXPECT_EQ(result.exit_status, 2) << result.output;
  EXPECT_THAT(result.output, HasSubstr("white.png: found a black image"));
}

TEST_F(PrismLightfieldTest, AFrameOfAnotherSizeIsBadInput) {
  cv::imwrite(Path("frame.png"), cv::Mat(320, 300, CV_8UC1, cv::Scalar(90)));
  const ProgramResult result = Run();
  EXPECT_EQ(result.exit_status, 2) << result.output;
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("frame.png"), HasSubstr("300 x 320"), HasSubstr("320 x 320")));
}

TEST_F(PrismLightfieldTest, InverseVirtualDepthOutsideItsRangeIsBadInput) {
  for (const std::string flag : {"--max_inverse_virtual_depth=0.6",
                                 "--min_inverse_virtual_depth=-0.1",
                                 "--min_inverse_virtual_depth=0.49"}) {
    const ProgramResult result = Run(flag);
    EXPECT_EQ(result.exit_status, 2) << flag << "\n" << result.output;
    EXPECT_THAT(result.output, HasSubstr("0.5")) << flag;
  }
}

TEST_F(PrismLightfieldTest, EstimatesTheGridFromAWhiteImageAlone) {
  PlenopticCamera without_grid = camera_;
  without_grid.micro_lens_grid.reset();
  WriteNativeCamera(Path("bare.yaml"), without_grid);
  const ProgramResult result =
      RunProgram("prism_lightfield --estimate_grid --camera=" + Path("bare.yaml") +
                 " --white_image=" + Path("white.png") + " --camera_out=" + Path("found.yaml"));
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const PlenopticCamera found = ReadPlenopticCamera(Path("found.yaml"));
  ASSERT_TRUE(found.micro_lens_grid);
  const MicroLensGrid& grid = *camera_.micro_lens_grid;
  for (double y = 10; y < 320; y += 20) {
    for (double x = 10; x < 320; x += 20) {
      const Eigen::Vector2d center =
          grid.MicroImageCenter(grid.NearestLens({x, y}, 320, 320), 320, 320);
      const Eigen::Vector2d other = found.micro_lens_grid->MicroImageCenter(
          found.micro_lens_grid->NearestLens(center, 320, 320), 320, 320);
      EXPECT_LT((center - other).norm(), 0.02) << "at " << center.transpose();
    }
  }
}

}  // namespace
}  // namespace prism
