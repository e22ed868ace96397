// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/camera/projection.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr char kScene[] =
    "name: board\nambient: 1.0\nbackground: [0.4, 0.4, 0.4]\n"
    "path: {position: [-1.6, 0, 0], target: [0, 0, 0], extent_m: 0.18}\ntextures: {}\n"
    "objects:\n  - {kind: calibration_board, squares: [6, 5], square_m: 0.06}\n";

class PrismCalibrateTest : public ::testing::Test {
 protected:
  PrismCalibrateTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("prism_calibrate_" + std::string(info->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~PrismCalibrateTest() override { fs::remove_all(folder_); }

  void Render(int pictures) const {
    WriteTextAtomically(Path("scene.yaml"), kScene);
    const ProgramResult result = RunProgram(
        "prism_simulate --scene=" + Path("scene.yaml") +
        " --trajectory=views --frames=" + std::to_string(pictures) + " --camera=" + Camera() +
        " --crop_px=1024 --samples=2 --truth_every=0 --output_dir=" + Path("pictures"));
    ASSERT_EQ(result.exit_status, 0) << result.output;
  }

  static std::string Camera() {
    return std::string(PRISM_SOURCE_DIR) + "/sequences/cameras/raytrix_r5_16mm_one_type.yaml";
  }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  ProgramResult Run(const std::string& flags) const {
    return RunProgram("prism_calibrate --sequence=" + Path("pictures") + " --square_mm=60 " +
                      flags);
  }

  fs::path folder_;
};

TEST_F(PrismCalibrateTest, FindsTheRenderedCameraFromWhatAnOwnerKnows) {
  Render(10);
  const ProgramResult result =
      Run("--squares=6x5 --focal_length_mm=17 --pixel_size_mm=0.0055 --output_dir=" + Path("out"));
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("left out"));
  const PlenopticCamera truth = ReadPlenopticCamera(Path("pictures/camera.yaml"));
  const PlenopticCamera found = ReadPlenopticCamera(Path("out/camera.yaml"));
  EXPECT_EQ(found.raw_width, truth.raw_width);
  ASSERT_TRUE(found.micro_lens_grid);
  for (const double z : {1.0, 2.0}) {
    const double w = InverseVirtualDepth(PlenopticProjection(truth), 1 / z);
    EXPECT_NEAR(1 / (InverseDepth(PlenopticProjection(found), w) * z), 1, 0.01) << z << " m";
  }
  const auto json = nlohmann::json::parse(ReadTextFile(Path("out/calibration.json")));
  EXPECT_GE(json["views"].size(), 10u);
  EXPECT_EQ(json["figures"][0]["name"], "f_L");
  EXPECT_GT(json["figures"][2]["sigma"].get<double>(), 0);
  EXPECT_THAT(ReadTextFile(Path("out/report.html")), HasSubstr("\"figures\""));
  for (const char* name : {"CameraModel.xml", "observations.csv", "distance_error.svg"}) {
    EXPECT_TRUE(fs::exists(Path("out") + "/" + name)) << name;
  }
  // A second time the same bytes.
  const std::string first = ReadTextFile(Path("out/observations.csv"));
  ASSERT_EQ(Run("--squares=6x5 --focal_length_mm=17 --pixel_size_mm=0.0055 --threads=1 "
                "--output_dir=" +
                Path("again"))
                .exit_status,
            0);
  EXPECT_EQ(ReadTextFile(Path("again/observations.csv")), first);
  EXPECT_EQ(ReadTextFile(Path("again/camera.yaml")), ReadTextFile(Path("out/camera.yaml")));
}

TEST_F(PrismCalibrateTest, SaysWhatIsWrongWithItsInput) {
  Render(1);
  const std::string camera = " --camera=" + Path("pictures/camera.yaml");
  const std::string out = " --output_dir=" + Path("bad");
  const auto expect = [&](const ProgramResult& result, const std::string& text) {
    EXPECT_EQ(result.exit_status, 2) << result.output;
    EXPECT_THAT(result.output, HasSubstr(text));
    EXPECT_FALSE(fs::exists(Path("bad/camera.yaml")));
  };
  expect(Run("--board=checkerboard --squares=6x5" + camera + out), "no checkerboard board");
  expect(Run("--squares=6by5" + camera + out), "'6by5'");
  expect(Run("--squares=2x5" + camera + out), "2x5 squares");
  expect(Run("--squares=6x5" + out), "--focal_length_mm and --pixel_size_mm");
  expect(Run("--squares=6x5 --distortion=much" + camera + out), "auto, none, radial or full");
  expect(RunProgram("prism_calibrate --micro_image_corners=/nowhere.csv "
                    "--micro_image_centers=/nowhere.csv --output_dir=" +
                    Path("bad") + camera),
         "/nowhere.csv");
}

TEST_F(PrismCalibrateTest, WritesTheBoardToPrint) {
  const ProgramResult result = RunProgram("prism_calibrate --write_board=" + Path("board.pdf"));
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_EQ(ReadTextFile(Path("board.pdf")).substr(0, 5), "%PDF-");
  const ProgramResult unwritable =
      RunProgram("prism_calibrate --write_board=" + Path("nowhere/board.pdf"));
  EXPECT_EQ(unwritable.exit_status, 2) << unwritable.output;
}

}  // namespace
}  // namespace prism
