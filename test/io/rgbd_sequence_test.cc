// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_sequence.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/camera/projection.h"
#include "prism/io/camera_file.h"
#include "prism/io/time_list.h"
#include "test/io/rgbd_folder.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::HasSubstr;

PlenopticCamera Lens() {
  return ReadPlenopticCamera(std::string(PRISM_SOURCE_DIR) + "/calib/raytrix_r5_16mm.yaml");
}

std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string OpenError(const std::string& folder) {
  return ErrorOf([&] { RgbdSequence(folder, Lens(), {}); });
}

TEST(RgbdSequence, TurnsAPinholeFrameIntoAFocusedFrameOfTheSameScene) {
  const std::string folder = FreshFolder("sequence");
  RgbdFolderOptions folder_options;
  folder_options.num_frames = 1;
  WriteRgbdFolder(folder, folder_options);
  RgbdConversionOptions options;
  options.inverse_depth_sigma = 0;
  const RgbdSequence sequence(folder, Lens(), options);
  const LightFieldFrame frame = sequence.Read(0);
  const PlenopticProjection camera(sequence.camera());
  const Eigen::Vector3d normal(-0.2, 0.1, 1);
  for (const Eigen::Vector2i& px :
       {Eigen::Vector2i(40, 30), Eigen::Vector2i(160, 120), Eigen::Vector2i(290, 200)}) {
    // The point the focused pixel shows lies on the plane, and its pinhole pixel has its texture.
    const double w = frame.inverse_virtual_depth(px.x(), px.y());
    ASSERT_GT(w, 0);
    const Eigen::Vector3d p =
        UnprojectInverseDepth(camera, px.cast<double>(), InverseDepth(camera, w));
    EXPECT_NEAR(normal.dot(p), 2, 2e-3);
    const double texture = 128 + 30 * std::sin(4.3 * p.x() + 1.1 * p.y()) +
                           25 * std::sin(11 * p.x() - 7 * p.y()) +
                           25 * std::sin(23 * p.x() + 3 * p.y()) * std::cos(19 * p.y()) +
                           20 * std::sin(41 * p.x() - 30 * p.y());
    EXPECT_NEAR(frame.image[0](px.x(), px.y()), texture, 1);
  }
}

TEST(RgbdSequence, NoiseHasTheStatedSigmaAndDependsOnSeedAndFrameOnly) {
  const std::string folder = FreshFolder("sequence");
  RgbdFolderOptions folder_options;
  folder_options.num_frames = 2;
  WriteRgbdFolder(folder, folder_options);
  RgbdConversionOptions options;
  options.inverse_depth_sigma = 0;
  const ImageF clean = RgbdSequence(folder, Lens(), options).Read(1).inverse_virtual_depth;
  options.inverse_depth_sigma = 0.004;
  options.seed = 5;
  const LightFieldFrame noisy = RgbdSequence(folder, Lens(), options).Read(1);
  const LightFieldFrame again = RgbdSequence(folder, Lens(), options).Read(1);
  options.seed = 6;
  const LightFieldFrame other = RgbdSequence(folder, Lens(), options).Read(1);
  double squared = 0, sum = 0;
  int count = 0, differing = 0;
  for (size_t i = 0; i < clean.size(); ++i) {
    EXPECT_EQ(noisy.inverse_virtual_depth.data()[i], again.inverse_virtual_depth.data()[i]);
    differing += noisy.inverse_virtual_depth.data()[i] != other.inverse_virtual_depth.data()[i];
    if (clean.data()[i] == 0) continue;
    const double error = noisy.inverse_virtual_depth.data()[i] - clean.data()[i];
    squared += error * error;
    sum += error;
    ++count;
    EXPECT_FLOAT_EQ(noisy.sigma.data()[i], 0.004f);
  }
  EXPECT_GT(differing, count / 2);
  EXPECT_NEAR(std::sqrt(squared / count), 0.004, 1e-4);
  EXPECT_NEAR(sum / count, 0, 1e-4);
}

TEST(RgbdSequence, HolesOfTheDepthMapAreNotMeasured) {
  PlenopticCamera camera = PlenopticFromPinhole({64, 48, 60, 60, 32, 24}, Lens());
  cv::Mat gray(48, 64, CV_8UC1, cv::Scalar(100));
  cv::Mat depth(48, 64, CV_32FC1, cv::Scalar(2));
  depth.colRange(20, 40).setTo(0);
  const LightFieldFrame frame = PlenopticFrameFromRgbd(camera, gray, depth, 0, 0, {});
  EXPECT_EQ(frame.inverse_virtual_depth(30, 24), 0);
  EXPECT_EQ(frame.sigma(30, 24), 0);
  EXPECT_GT(frame.inverse_virtual_depth(10, 24), 0);
}

// The image in a hole of the depth map is where the depths beside it say.
TEST(RgbdSequence, HolesAreResampledWithTheNearestDepth) {
  const PlenopticCamera camera = PlenopticFromPinhole({64, 48, 60, 60, 32, 24}, Lens());
  const PlenopticProjection projection(camera);
  cv::Mat gray(48, 64, CV_8UC1), depth(48, 64, CV_32FC1, cv::Scalar(0.2));
  for (int x = 0; x < 64; ++x) gray.col(x).setTo(4 * x);
  depth.colRange(40, 64).setTo(3);
  depth({10, 5, 40, 40}).setTo(0);
  const LightFieldFrame frame = PlenopticFrameFromRgbd(camera, gray, depth, 0, 0, {});
  const auto expected = [&](int x, double depth_m) {
    const double scale = (projection.b_L0 + 2 * projection.B) * (1 / projection.f - 1 / depth_m);
    return 4 * (projection.c.x() + scale * (x - projection.c.x()));
  };
  EXPECT_NEAR(frame.image[0](14, 24), expected(14, 0.2), 0.2);
  EXPECT_NEAR(frame.image[0](46, 24), expected(46, 3), 0.2);
  EXPECT_NEAR(frame.image[0](25, 6), expected(25, 0.2), 0.2);
  EXPECT_GT(std::abs(expected(14, 0.2) - expected(14, 3)), 4);
}

TEST(RgbdSequence, BadFoldersAreNamedWithWhatWasExpected) {
  EXPECT_THAT(OpenError("no/such/folder"), AllOf(HasSubstr("no/such/folder"), HasSubstr("found")));
  const std::string empty = FreshFolder("empty");
  WriteFile(empty + "/calibration.txt", "262.5 262.5 160 120 320 240\n");
  EXPECT_THAT(OpenError(empty), HasSubstr("expected a sequence in TUM RGB-D layout"));

  const std::string folder = FreshFolder("sequence");
  RgbdFolderOptions two_frames;
  two_frames.num_frames = 2;
  WriteRgbdFolder(folder, two_frames);
  WriteFile(folder + "/associations.txt", "   \n# nothing\n");
  EXPECT_THAT(OpenError(folder), AllOf(HasSubstr("associations.txt"), HasSubstr("no entries")));
  WriteFile(folder + "/associations.txt",
            "0.1 rgb/000000.png 0.1 depth/000000.png\n0.0 rgb/000001.png 0.0 depth/000001.png\n");
  EXPECT_THAT(OpenError(folder), AllOf(HasSubstr("associations.txt:2"), HasSubstr("increase")));
  WriteFile(folder + "/associations.txt", "nan rgb/000000.png 0.1 depth/000000.png\n");
  EXPECT_THAT(OpenError(folder), HasSubstr("a time in seconds"));
  WriteFile(folder + "/associations.txt", "0.1 rgb/000009.png 0.1 depth/000000.png\n");
  EXPECT_THAT(OpenError(folder), AllOf(HasSubstr("rgb/000009.png"), HasSubstr("no such file")));
}

TEST(RgbdSequence, ADepthFileWithoutItsImageIsAnError) {
  const std::string folder = FreshFolder("sequence");
  RgbdFolderOptions two_frames;
  two_frames.num_frames = 2;
  WriteRgbdFolder(folder, two_frames);
  std::filesystem::remove(folder + "/associations.txt");
  WriteFile(folder + "/rgb.txt", "0.0 rgb/000000.png\n");
  WriteFile(folder + "/depth.txt", "0.0 depth/000000.png\n0.1 depth/000001.png\n");
  EXPECT_THAT(OpenError(folder), AllOf(HasSubstr("depth.txt:2"), HasSubstr("100.0")));
  WriteFile(folder + "/rgb.txt", "0.0 rgb/000000.png\n0.09 rgb/000001.png\n");
  EXPECT_EQ(OpenError(folder), "");
}

TEST(RgbdSequence, AnImageThatDoesNotDecodeOrHasAnotherSizeIsAnError) {
  const std::string folder = FreshFolder("sequence");
  RgbdFolderOptions one_frame;
  one_frame.num_frames = 1;
  WriteRgbdFolder(folder, one_frame);
  const auto read_error = [&] {
    return ErrorOf([&] { RgbdSequence(folder, Lens(), {}).Read(0); });
  };
  EXPECT_EQ(read_error(), "");
  cv::imwrite(folder + "/rgb/000000.png", cv::Mat(10, 20, CV_8UC1, cv::Scalar(0)));
  EXPECT_THAT(read_error(), AllOf(HasSubstr("20 x 10"), HasSubstr("320 x 240")));
  WriteFile(folder + "/rgb/000000.png", "not an image");
  EXPECT_THAT(read_error(), HasSubstr("does not decode"));
  WriteRgbdFolder(folder, one_frame);
  cv::imwrite(folder + "/depth/000000.png", cv::Mat(240, 320, CV_8UC1, cv::Scalar(9)));
  EXPECT_THAT(read_error(), AllOf(HasSubstr("8 bits"), HasSubstr("16 bits")));
}

}  // namespace
}  // namespace prism
