// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/raw_sequence.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

class SequenceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + "prism_sequence_" +
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ + "/" + name) << text;
  }
  std::string folder_;
  PlenopticCamera camera_ = SmallCamera(64);
};

TEST_F(SequenceTest, FocusedFramesComeBackAsWritten) {
  LightFieldFrame frame;
  frame.time_ns = 1234567890;
  frame.image.push_back(ImageF(32, 32, 77));
  frame.inverse_virtual_depth = ImageF(32, 32, 0);
  frame.sigma = ImageF(32, 32, 0);
  frame.inverse_virtual_depth(3, 4) = 0.3f;
  frame.sigma(3, 4) = 0.005f;
  FocusedSequenceWriter writer(folder_);
  writer.Write(frame);
  writer.Finish();
  ASSERT_TRUE(IsFocusedSequence(folder_));
  const FocusedSequence sequence(folder_, camera_);
  ASSERT_EQ(sequence.size(), 1);
  const LightFieldFrame read = sequence.Read(0);
  EXPECT_EQ(read.time_ns, frame.time_ns);
  EXPECT_EQ(read.image[0](10, 10), 77);
  EXPECT_NEAR(read.inverse_virtual_depth(3, 4), 0.3, 1e-5);
  EXPECT_NEAR(read.sigma(3, 4), 0.005, 2e-6);
  EXPECT_EQ(read.inverse_virtual_depth(5, 4), 0);
}

TEST_F(SequenceTest, InverseVirtualDepthBeyondOneHalfIsBadInput) {
  cv::Mat depth(32, 32, CV_16UC1, cv::Scalar(0));
  depth.at<uint16_t>(1, 1) = 20000;  // 1/v = 0.69
  cv::imwrite(folder_ + "/d.png", depth);
  EXPECT_THROW(ReadInverseVirtualDepth(folder_ + "/d.png", 32, 32), InputError);
}

TEST_F(SequenceTest, BadRawSequencesAreInputErrors) {
  EXPECT_THROW(RawSequence(folder_, camera_), InputError);  // no list
  Write("raw.txt", "1.0 missing.png\n");
  EXPECT_THROW(RawSequence(folder_, camera_), InputError);
  cv::imwrite(folder_ + "/a.png", cv::Mat(64, 64, CV_8UC1, cv::Scalar(9)));
  Write("raw.txt", "1.0 a.png\n0.5 a.png\n");
  EXPECT_THROW(RawSequence(folder_, camera_), InputError);  // times go back
  cv::imwrite(folder_ + "/small.png", cv::Mat(32, 64, CV_8UC1, cv::Scalar(9)));
  Write("raw.txt", "1.0 a.png\n2.0 small.png\n");
  const RawSequence sequence(folder_, camera_);
  EXPECT_EQ(sequence.Read(0).image.rows, 64);
  EXPECT_THROW(sequence.Read(1), InputError);
}

TEST_F(SequenceTest, ColourWhereGrayIsDeclaredIsBadInput) {
  cv::imwrite(folder_ + "/gray.png", cv::Mat(64, 64, CV_8UC1, cv::Scalar(9)));
  cv::imwrite(folder_ + "/colour.png", cv::Mat(64, 64, CV_8UC3, cv::Scalar(9, 8, 7)));
  Write("raw.txt", "1.0 gray.png\n2.0 colour.png\n");
  const RawSequence one_channel(folder_, camera_, 1);
  EXPECT_NO_THROW(one_channel.Read(0));
  EXPECT_THROW(one_channel.Read(1), InputError);
  const RawSequence three_channels(folder_, camera_, 3);
  EXPECT_THROW(three_channels.Read(0), InputError);
  EXPECT_NO_THROW(three_channels.Read(1));
  const RawSequence any(folder_, camera_);
  EXPECT_NO_THROW(any.Read(0));
  EXPECT_NO_THROW(any.Read(1));
}

TEST_F(SequenceTest, BlackWhiteImageIsBadInput) {
  cv::imwrite(folder_ + "/white.png", cv::Mat(64, 64, CV_8UC1, cv::Scalar(1)));
  EXPECT_THROW(ReadWhiteImage(folder_ + "/white.png", camera_), InputError);
}

}  // namespace
}  // namespace prism
