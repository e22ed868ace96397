// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/simulate_sequence.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/image_file.h"
#include "prism/io/time_list.h"
#include "prism/io/trajectory_file.h"
#include "test/sim/test_scene.h"

namespace prism {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class SimulateSequenceTest : public testing::Test {
 protected:
  SimulateSequenceTest()
      : folder_(testing::TempDir() + "simulate_sequence_test_" +
                testing::UnitTest::GetInstance()->current_test_info()->name()),
        camera_(SmallCamera()),
        scene_(WhiteScene()) {
    fs::remove_all(folder_);
    AddPatch({1.5, 0, 0}, {0, -0.6, 0}, {0, 0, -0.4}, &scene_);
    scene_.path.position = Eigen::Vector3d::Zero();
    scene_.path.target = {1, 0, 0};
    scene_.path.extent = 0.1;
    MotionOptions motion;
    motion.num_frames = 3;
    motion_ = GenerateMotion(motion, scene_.path);
    options_.truth_every = 2;
    options_.preview = true;
    options_.exposure_s = 0;
  }
  ~SimulateSequenceTest() override { fs::remove_all(folder_); }

  // Number of frames rendered anew.
  int Simulate(const std::string& description = "--seed=1\n") {
    int rendered = 0;
    SimulateSequence(scene_,
                     camera_,
                     motion_,
                     "test motion",
                     options_,
                     description,
                     folder_,
                     [&](const SimulateProgress& progress) { rendered += !progress.reused; });
    return rendered;
  }

  std::string ErrorOfSimulate(const std::string& description = "--seed=1\n") {
    try {
      Simulate(description);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::string folder_;
  PlenopticCamera camera_;
  SimScene scene_;
  CameraMotion motion_;
  SimulateOptions options_;
};

TEST_F(SimulateSequenceTest, WritesTheLayoutOfARawSequence) {
  EXPECT_EQ(Simulate(), 3);
  const auto list = ReadTimeList(folder_ + "/raw.txt", 1);
  const Trajectory truth = ReadTrajectory(folder_ + "/groundtruth.txt");
  ASSERT_EQ(list.size(), 3u);
  ASSERT_EQ(truth.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(list[i].time_ns, truth[i].time_ns);
    ReadGrayImage(folder_ + "/" + list[i].words[0], 480, 480);
  }
  ReadGrayImage(folder_ + "/white.png", 480, 480);
  ReadGrayImage(folder_ + "/preview/000001.png", 240, 240);
  EXPECT_FALSE(fs::exists(folder_ + "/depth_truth/000001.tiff"));
  const cv::Mat depth = ReadImageUnchanged(folder_ + "/depth_truth/000002.tiff");
  ASSERT_EQ(depth.type(), CV_32FC1);
  const cv::Mat encoded = Read16BitImage(folder_ + "/virtual_depth_truth/000002.png", 240, 240);
  const double z = depth.at<float>(120, 120);
  EXPECT_NEAR(z, 1.5, 0.01);
  const double b_L = 1 / (1 / camera_.focal_length - 1 / z);
  EXPECT_NEAR(1 - encoded.at<uint16_t>(120, 120) / 65535.0,
              camera_.sensor_mla_distance / (b_L - camera_.main_lens_mla_distance),
              1e-5);
}

TEST_F(SimulateSequenceTest, TheThreeCameraFilesAgree) {
  Simulate();
  const PlenopticCamera native = ReadPlenopticCamera(folder_ + "/camera.yaml");
  const PlenopticCamera lifcal = ReadPlenopticCamera(folder_ + "/CameraModel.xml");
  const MicroLensGrid grid = ReadMicroLensGrid(folder_ + "/MLA_Calibration.xml");
  EXPECT_NEAR(native.focal_length, lifcal.focal_length, 1e-15);
  EXPECT_LT((native.raw_principal_point - lifcal.raw_principal_point).norm(), 1e-10);
  EXPECT_LT((native.micro_lens_grid->MicroImageCenter({9, -7}, 480, 480) -
             grid.MicroImageCenter({9, -7}, 480, 480))
                .norm(),
            1e-9);
}

TEST_F(SimulateSequenceTest, GoesOnWhereItWasStoppedWithTheSamePixels) {
  Simulate();
  const std::string second = ReadTextFile(folder_ + "/raw/000001.png");
  fs::remove(folder_ + "/raw/000001.png");
  fs::remove(folder_ + "/raw.txt");
  EXPECT_EQ(Simulate(), 1);
  EXPECT_EQ(ReadTextFile(folder_ + "/raw/000001.png"), second);
  EXPECT_TRUE(fs::exists(folder_ + "/raw.txt"));
}

TEST_F(SimulateSequenceTest, FramesOfOtherOptionsAreNotMixed) {
  Simulate();
  const std::string error = ErrorOfSimulate("--seed=2\n");
  EXPECT_THAT(error, HasSubstr("simulate.txt: found frames rendered with '--seed=1'"));
  options_.replace = true;
  EXPECT_EQ(Simulate("--seed=2\n"), 3);
  EXPECT_EQ(Simulate("--seed=2\n"), 0);
}

TEST_F(SimulateSequenceTest, BrightnessChangesOnceUpAndDownOverTheSequence) {
  options_.sensor.full_well_electrons = 0;
  options_.exposure_change = 0.08;
  motion_ = FollowTrajectory({{0, motion_.AtFrames()[0].world_from_cam},
                              {100000000, motion_.AtFrames()[0].world_from_cam},
                              {200000000, motion_.AtFrames()[0].world_from_cam},
                              {300000000, motion_.AtFrames()[0].world_from_cam}});
  Simulate();
  const auto mean = [&](int frame) {
    return cv::mean(ReadImageUnchanged(folder_ + "/raw/00000" + std::to_string(frame) + ".png"))[0];
  };
  EXPECT_NEAR(mean(1) / mean(0), 1.08, 0.005);
  EXPECT_NEAR(mean(2) / mean(0), 1.00, 0.005);
  EXPECT_NEAR(mean(3) / mean(0), 0.92, 0.005);
}

TEST_F(SimulateSequenceTest, AFrameIsTakenAroundItsTimeForAsLongAsTheExposure) {
  // 4 cm in 0.1 s across the patch; 50 ms blur its borders over 2 cm, to both sides alike.
  const SE3 start = motion_.AtFrames()[0].world_from_cam;
  const SE3 step(Eigen::Quaterniond::Identity(), {0.04, 0, 0});
  motion_ = FollowTrajectory(
      {{0, start * step.Inverse()}, {100000000, start}, {200000000, start * step}});
  options_.sensor.full_well_electrons = 0;
  const auto middle_frame = [&](double exposure_s) {
    options_.exposure_s = exposure_s;
    options_.replace = true;
    Simulate("--exposure_s=" + std::to_string(exposure_s) + "\n");
    cv::Mat image = ReadImageUnchanged(folder_ + "/raw/000001.png");
    image.convertTo(image, CV_32F);
    return image;
  };
  const cv::Mat sharp = middle_frame(0);
  const cv::Mat blurred = middle_frame(0.05);
  EXPECT_GT(cv::norm(sharp, blurred, cv::NORM_L1) / sharp.total(), 1);
  EXPECT_NEAR(cv::mean(blurred)[0], cv::mean(sharp)[0], 0.01 * cv::mean(sharp)[0]);
  const cv::Moments a = cv::moments(sharp);
  const cv::Moments b = cv::moments(blurred);
  EXPECT_NEAR(a.m10 / a.m00, b.m10 / b.m00, 0.5);
}

TEST_F(SimulateSequenceTest, ACameraInsideGeometryIsRefusedBeforeAnythingIsWritten) {
  AddBox(Placement({0, 0, -0.5}, 0), {1, 1, 1}, SurfaceStyle(), &scene_.meshes[0]);
  EXPECT_THAT(ErrorOfSimulate(), HasSubstr("test motion: found frame 0"));
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(SimulateSequenceTest, ACameraThatTouchesASurfaceIsRefused) {
  AddPatch({0.01, 0, 0}, {0, 0, 1}, {0, 1, 0}, &scene_);
  scene_.meshes[0].double_sided = true;
  EXPECT_THAT(ErrorOfSimulate(), HasSubstr("touching a surface"));
}

}  // namespace
}  // namespace prism
