// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/sequence.h"

#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "prism/io/rgbd_sequence.h"
#include "prism/odometry/odometry.h"
#include "test/io/rgbd_folder.h"

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

TEST_F(SequenceOfRgbd, TimesTheFramesThatWereReturned) {
  Sequence sequence(options_);
  EXPECT_THAT(sequence.timer().Summarize(), testing::IsEmpty());
  for (int i = 1; i <= 2; ++i) {
    ASSERT_TRUE(sequence.Next());
    const auto stages = sequence.timer().Summarize();
    ASSERT_EQ(stages.size(), 2u);
    for (const char* stage : {"read image", "convert frame"}) {
      EXPECT_EQ(stages.at(stage).count, i) << stage;
      EXPECT_GT(stages.at(stage).total_ms, 0) << stage;
    }
  }
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
  } catch (const UnreadableFrame& error) {
    EXPECT_THAT(error.what(), HasSubstr("rgb/000001.png"));
    EXPECT_EQ(error.time_ns, kTick);
  }
  EXPECT_THAT(TimesOfAllFrames(&sequence), ElementsAre(2, 3, 4, 5));
}

TEST_F(SequenceOfRgbd, AMissingFileIsAnErrorBeforeTheStartOrAFrame) {
  std::filesystem::remove(options_.sequence + "/depth/000001.png");
  EXPECT_THAT(MessageOf(options_), HasSubstr("depth/000001.png: found no such file"));
  options_.skip_missing = true;
  Sequence sequence(options_);
  EXPECT_EQ(sequence.Next()->time_ns, 0);
  EXPECT_THROW(sequence.Next(), UnreadableFrame);
  EXPECT_THAT(TimesOfAllFrames(&sequence), ElementsAre(2, 3, 4, 5));
}

// The frames around one that did not come are as if nobody had expected it.
TEST_F(SequenceOfRgbd, ASkippedFrameChangesNothingForTheOthers) {
  const auto poses_with = [&](bool is_told) {
    options_.rgbd.inverse_depth_sigma = 0;
    Sequence sequence(options_);
    OdometryOptions options;
    options.min_start_points = 20;
    Odometry odometry(sequence.camera(), options);
    for (int i = 0; auto frame = sequence.Next(); ++i) {
      if (i != 3) {
        odometry.Process(std::move(*frame));
        continue;
      }
      if (!is_told) continue;
      const FrameResult skipped = odometry.Skip(frame->time_ns);
      EXPECT_EQ(skipped.status, FrameStatus::kUnreadable);
      EXPECT_EQ(skipped.time_ns, 3 * kTick);
      EXPECT_FALSE(HasPose(skipped.status));
    }
    std::vector<double> values;
    for (const StampedPose& pose : odometry.FrameTrajectory()) {
      values.insert(values.end(), pose.world_from_cam.data(), pose.world_from_cam.data() + 7);
    }
    return values;
  };
  EXPECT_EQ(poses_with(true), poses_with(false));
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
  EXPECT_THAT(message_with([](SequenceOptions* o) { o->colour = "sepia"; }),
              HasSubstr("colour: found 'sepia', expected auto, gray"));
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

}  // namespace
}  // namespace prism
