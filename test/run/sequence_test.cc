// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/sequence.h"

#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/rgbd_sequence.h"
#include "prism/odometry/odometry.h"
#include "test/run/raw_folder.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kTick = 100000000;  // ns between frames of the folders below

std::vector<int64_t> TimesOfAllFrames(Sequence* sequence) {
  std::vector<int64_t> times;
  while (const auto frame = sequence->Next()) times.push_back(frame->time_ns / kTick);
  return times;
}

std::string MessageOf(const SequenceOptions& options) {
  try {
    Sequence sequence(options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

bool AreEqual(const ImageF& a, const ImageF& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(float) * a.size()) == 0;
}

class SequenceOfRgbd : public testing::Test {
 protected:
  SequenceOfRgbd() {
    RgbdFolderOptions folder;
    folder.num_frames = 6;
    folder.width = 160;
    folder.height = 120;
    folder.focal_length_px = 131;
    options_.sequence = FreshFolder("rgbd");
    options_.camera = PRISM_SOURCE_DIR "/calib/raytrix_r5_16mm.yaml";
    WriteRgbdFolder(options_.sequence, folder);
  }

  SequenceOptions options_;
};

TEST_F(SequenceOfRgbd, GivesTheFramesOfTheFolder) {
  Sequence sequence(options_);
  EXPECT_EQ(sequence.format(), "rgbd");
  EXPECT_EQ(sequence.size(), 6);
  EXPECT_EQ(sequence.grid_report(), "");
  const RgbdSequence reader(options_.sequence, ReadPlenopticCamera(options_.camera), options_.rgbd);
  EXPECT_EQ(sequence.camera().raw_width, reader.camera().raw_width);
  for (int i = 0; i < 6; ++i) {
    const std::optional<LightFieldFrame> frame = sequence.Next();
    ASSERT_TRUE(frame);
    const LightFieldFrame expected = reader.Read(i);
    EXPECT_EQ(frame->time_ns, expected.time_ns);
    EXPECT_TRUE(AreEqual(frame->image[0], expected.image[0]));
    EXPECT_TRUE(AreEqual(frame->inverse_virtual_depth, expected.inverse_virtual_depth));
  }
  EXPECT_FALSE(sequence.Next());
  EXPECT_FALSE(sequence.Next());
}

TEST_F(SequenceOfRgbd, PlaysAPieceOfTheFile) {
  options_.start_frame = 2;
  options_.max_frames = 3;
  Sequence sequence(options_);
  EXPECT_EQ(sequence.size(), 3);
  EXPECT_THAT(TimesOfAllFrames(&sequence), ElementsAre(2, 3, 4));
  options_.max_frames = 100;
  EXPECT_EQ(Sequence(options_).size(), 4);
}

TEST_F(SequenceOfRgbd, BackAndForthIsTheFrameOfTheFileAtTheTimeOfThePlay) {
  options_.start_frame = 1;
  options_.max_frames = 3;
  options_.reverse = true;
  options_.ping_pong = 2;
  Sequence sequence(options_);
  const RgbdSequence reader(options_.sequence, ReadPlenopticCamera(options_.camera), options_.rgbd);
  int64_t time = 1;
  for (const int file_index : {3, 2, 1, 2, 3}) {
    const std::optional<LightFieldFrame> frame = sequence.Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time_ns, kTick * time++);
    EXPECT_TRUE(AreEqual(frame->image[0], reader.Read(file_index).image[0]));
  }
  EXPECT_FALSE(sequence.Next());
}

// Frames are opened although nobody asked for them yet.
TEST_F(SequenceOfRgbd, ReadsAhead) {
  Sequence sequence(options_);
  const int events = inotify_init1(IN_NONBLOCK);
  ASSERT_GE(inotify_add_watch(events, (options_.sequence + "/rgb").c_str(), IN_OPEN), 0);
  ASSERT_TRUE(sequence.Next());
  bool has_opened_the_fourth = false;
  pollfd waiting = {events, POLLIN, 0};
  while (!has_opened_the_fourth && poll(&waiting, 1, 20000) > 0) {
    alignas(inotify_event) char buffer[4096];
    const ssize_t length = read(events, buffer, sizeof(buffer));
    for (ssize_t at = 0; at < length;) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer + at);
      has_opened_the_fourth |= std::strcmp(event->name, "000003.png") == 0;
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    }
  }
  close(events);
  EXPECT_TRUE(has_opened_the_fourth);
}

TEST_F(SequenceOfRgbd, MayBeDroppedInTheMiddle) {
  Sequence sequence(options_);
  EXPECT_TRUE(sequence.Next());
}

TEST_F(SequenceOfRgbd, GoesOnBehindAFrameThatCannotBeRead) {
  WriteFile(options_.sequence + "/rgb/000001.png", "not an image");
  Sequence sequence(options_);
  EXPECT_EQ(sequence.Next()->time_ns, 0);
  try {
    sequence.Next();
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("rgb/000001.png"));
  }
  EXPECT_THAT(TimesOfAllFrames(&sequence), ElementsAre(2, 3, 4, 5));
}

TEST_F(SequenceOfRgbd, FeedsTheOdometry) {
  Sequence sequence(options_);
  OdometryOptions options;
  options.min_start_points = 20;  // small images
  Odometry odometry(sequence.camera(), options);
  while (auto frame = sequence.Next()) odometry.Process(std::move(*frame));
  EXPECT_FALSE(odometry.FrameTrajectory().empty());
}

TEST_F(SequenceOfRgbd, BadOptionsAreNamed) {
  const auto message_with = [&](auto change) {
    SequenceOptions options = options_;
    change(&options);
    return MessageOf(options);
  };
  EXPECT_EQ(message_with([](SequenceOptions* o) { o->format = "film"; }),
            "format: found 'film', expected raw, focused or rgbd");
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->start_frame = 6; }),
              HasSubstr("start_frame: found 6, expected 0 to 5, the last frame of "));
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->start_frame = -1; }),
              HasSubstr("start_frame: found -1"));
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->max_frames = -1; }),
              HasSubstr("max_frames: found -1"));
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->ping_pong = -1; }),
              HasSubstr("ping_pong: found -1"));
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->threads = -1; }),
              HasSubstr("threads: found -1"));
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->rgbd.inverse_depth_sigma = 1; }),
              HasSubstr("rgbd_inverse_depth_sigma: found 1"));
  std::string error;
  EXPECT_TRUE(options_.IsValid(&error));
  options_.format = "film";
  EXPECT_FALSE(options_.IsValid(&error));
  EXPECT_EQ(error, "format of 'film', expected raw, focused or rgbd");
}

TEST_F(SequenceOfRgbd, BadFilesAreNamed) {
  SequenceOptions nowhere = options_;
  nowhere.sequence += "/nowhere";
  EXPECT_THAT(MessageOf(nowhere), HasSubstr("nowhere: found no such folder"));
  SequenceOptions no_camera = options_;
  no_camera.camera = "/no/camera.yaml";
  EXPECT_THAT(MessageOf(no_camera), HasSubstr("/no/camera.yaml"));
  SequenceOptions other_format = options_;
  other_format.format = "focused";
  EXPECT_THAT(MessageOf(other_format), HasSubstr("focused.txt"));
  std::filesystem::remove(options_.sequence + "/associations.txt");
  EXPECT_THAT(MessageOf(options_),
              AllOf(HasSubstr("found neither raw.txt"), HasSubstr(options_.sequence)));
}

TEST(SequenceOfFocusedFrames, ComesBackAsWritten) {
  SequenceOptions options;
  options.sequence = FreshFolder("focused");
  options.camera = options.sequence + "/camera.yaml";
  const PlenopticCamera camera = SmallCamera(64);
  WriteNativeCamera(options.camera, camera);
  FocusedSequenceWriter writer(options.sequence);
  for (int i = 0; i < 3; ++i) {
    LightFieldFrame frame;
    frame.time_ns = i * kTick;
    frame.image.push_back(ImageF(32, 32, static_cast<float>(10 * i)));
    frame.inverse_virtual_depth = ImageF(32, 32, 0);
    frame.sigma = ImageF(32, 32, 0);
    writer.Write(frame);
  }
  writer.Finish();
  options.reverse = true;
  Sequence sequence(options);
  EXPECT_EQ(sequence.format(), "focused");
  EXPECT_EQ(sequence.camera().focused_width(), 32);
  for (const float value : {20.0f, 10.0f, 0.0f}) EXPECT_EQ(sequence.Next()->image[0](5, 5), value);
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

TEST(SequenceOfRawFrames, NeedsAColourItKnows) {
  SequenceOptions options;
  options.sequence = FreshFolder("raw");
  options.camera = options.sequence + "/camera.yaml";
  WriteRawFolder(options.sequence, 1);
  options.colour = "sepia";
  EXPECT_THAT(MessageOf(options), HasSubstr("colour: found 'sepia'"));
}

}  // namespace
}  // namespace prism
