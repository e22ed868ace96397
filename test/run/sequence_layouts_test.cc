// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Sequence on the layouts of plenoptic cameras; sequence_test.cc has what all layouts share.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/io/focused_sequence.h"
#include "prism/run/sequence.h"
#include "test/run/raw_folder.h"

namespace prism {
namespace {

using testing::HasSubstr;

constexpr int64_t kTick = 100000000;  // ns between frames of the folders below

TEST(SequenceOfFocusedFrames, ComesBackAsWritten) {
  SequenceOptions options;
  options.sequence = FreshFolder("focused");
  options.camera = options.sequence + "/camera.yaml";
  const PlenopticCamera camera = SmallCamera(192);
  WriteNativeCamera(options.camera, camera);
  FocusedSequenceWriter writer(options.sequence);
  for (int i = 0; i < 3; ++i) {
    LightFieldFrame frame;
    frame.time_ns = i * kTick;
    frame.image.push_back(ImageF(96, 96, static_cast<float>(10 * i)));
    frame.inverse_virtual_depth = ImageF(96, 96, 0);
    frame.sigma = ImageF(96, 96, 0);
    writer.Write(frame);
  }
  writer.Finish();
  options.reverse = true;
  Sequence sequence(options);
  EXPECT_EQ(sequence.format(), "focused");
  EXPECT_EQ(sequence.camera().focused_width(), 96);
  for (const float value : {20.0f, 10.0f, 0.0f}) EXPECT_EQ(sequence.Next()->image[0](5, 5), value);
  EXPECT_EQ(sequence.timer().Summarize().at("read image").count, 3);
  EXPECT_EQ(sequence.camera().focused_image, FocusedImage::kChiefRays);
  options.focused_image = "virtual_points";
  EXPECT_EQ(Sequence(options).camera().focused_image, FocusedImage::kVirtualPoints);
  options.focused_image = "rays";
  std::string error;
  EXPECT_FALSE(options.IsValid(&error));
  EXPECT_EQ(error, "focused_image of 'rays', expected virtual_points or chief_rays");
}

TEST(SequenceOfRawFrames, IsTurnedIntoDepthAndFocusedImages) {
  SequenceOptions options;
  options.sequence = FreshFolder("raw");
  options.camera = options.sequence + "/camera.yaml";
  WriteRawFolder(options.sequence, 3);
  Sequence sequence(options);
  EXPECT_EQ(sequence.format(), "raw");
  EXPECT_THAT(sequence.grid_report(), HasSubstr("refined on the white image"));
  for (int i = 0; i < 3; ++i) {
    const std::optional<LightFieldFrame> frame = sequence.Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time_ns, i * kTick);
    std::vector<float> measured;
    for (int y = 30; y < 130; ++y) {
      for (int x = 30; x < 130; ++x) {
        if (frame->sigma(x, y) > 0) measured.push_back(frame->inverse_virtual_depth(x, y));
      }
    }
    ASSERT_GT(measured.size(), 1000u);
    std::sort(measured.begin(), measured.end());
    EXPECT_NEAR(measured[measured.size() / 2], 0.25 + 0.02 * i, 0.003);
  }
  EXPECT_FALSE(sequence.Next());
  const auto stages = sequence.timer().Summarize();
  EXPECT_GE(stages.size(), 4u) << "those of LightFieldProcessor, and reading";
  for (const auto& [stage, times] : stages) EXPECT_EQ(times.count, 3) << stage;
  EXPECT_EQ(stages.count("read image"), 1u);
}

long ThreadsOfThisProcess() {
  using Entries = std::filesystem::directory_iterator;
  return std::distance(Entries("/proc/self/task"), Entries());
}

// TBB keeps its threads: whoever joined is still there afterwards.
TEST(SequenceOfRawFrames, OneThreadMeansNoHelpers) {
  SequenceOptions options;
  options.sequence = FreshFolder("raw");
  options.camera = options.sequence + "/camera.yaml";
  WriteRawFolder(options.sequence, 2);
  std::filesystem::remove(options.sequence + "/white.png");  // the frames' grid takes part
  options.threads = 1;
  const long before = ThreadsOfThisProcess();
  {
    Sequence sequence(options);
    while (sequence.Next()) continue;
  }
  EXPECT_LE(ThreadsOfThisProcess(), before);
}

}  // namespace
}  // namespace prism
