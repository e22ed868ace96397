// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/play_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prism {
namespace {

using testing::ElementsAre;

// Uneven on purpose: mirroring must not rely on a frame rate.
const std::vector<int64_t> kFileTimes = {100, 110, 140, 200};

std::vector<int> Indices(const PlayOrder& order) {
  std::vector<int> indices;
  for (int n = 0; n < order.size(); ++n) indices.push_back(order.file_index(n));
  return indices;
}

std::vector<int64_t> Times(const PlayOrder& order) {
  std::vector<int64_t> times_ns;
  for (int n = 0; n < order.size(); ++n) times_ns.push_back(order.time_ns(n));
  return times_ns;
}

std::vector<int64_t> Times(const Trajectory& trajectory) {
  std::vector<int64_t> times_ns;
  for (const StampedPose& pose : trajectory) times_ns.push_back(pose.time_ns);
  return times_ns;
}

// A pose whose place says which time of the file it belongs to.
Trajectory TrajectoryAt(const std::vector<int64_t>& times_ns) {
  Trajectory trajectory;
  for (const int64_t time_ns : times_ns) {
    const Eigen::Vector3d place(static_cast<double>(time_ns), 0, 0);
    trajectory.push_back({time_ns, SE3(Eigen::Quaterniond::Identity(), place)});
  }
  return trajectory;
}

std::vector<double> Places(const Trajectory& trajectory) {
  std::vector<double> places;
  for (const StampedPose& pose : trajectory) {
    places.push_back(pose.world_from_cam.translation().x());
  }
  return places;
}

TEST(PlayOrder, ForwardsIsTheFile) {
  const PlayOrder order(kFileTimes);
  EXPECT_THAT(Indices(order), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(Times(order), kFileTimes);
  const Trajectory trajectory = TrajectoryAt({90, 140, 220});
  EXPECT_THAT(Times(order.AsPlayed(trajectory)), ElementsAre(90, 140, 220));
  EXPECT_THAT(Times(order.InFileTimes(trajectory)), ElementsAre(90, 140, 220));
}

TEST(PlayOrder, ReverseMirrorsTheTimes) {
  const PlayOrder order(kFileTimes, {true, 1});
  EXPECT_THAT(Indices(order), ElementsAre(3, 2, 1, 0));
  EXPECT_THAT(Times(order), ElementsAre(100, 160, 190, 200));
}

TEST(PlayOrder, PingPongPlaysTheTurningFrameOnce) {
  const PlayOrder order(kFileTimes, {false, 3});
  EXPECT_THAT(Indices(order), ElementsAre(0, 1, 2, 3, 2, 1, 0, 1, 2, 3));
  EXPECT_THAT(Times(order), ElementsAre(100, 110, 140, 200, 260, 290, 300, 310, 340, 400));
  const PlayOrder reversed(kFileTimes, {true, 2});
  EXPECT_THAT(Indices(reversed), ElementsAre(3, 2, 1, 0, 1, 2, 3));
  EXPECT_THAT(Times(reversed), ElementsAre(100, 160, 190, 200, 210, 240, 300));
}

TEST(PlayOrder, OneFrameStaysOneFrame) {
  const PlayOrder order({7}, {true, 4});
  EXPECT_THAT(Indices(order), ElementsAre(0));
  EXPECT_THAT(Times(order), ElementsAre(7));
}

TEST(PlayOrder, ATrajectoryIsPlayedAsTheFramesAre) {
  // With poses before, between and after the frames.
  const Trajectory filed = TrajectoryAt({90, 100, 120, 140, 200, 220});
  const PlayOrder reversed(kFileTimes, {true, 1});
  EXPECT_THAT(Times(reversed.AsPlayed(filed)), ElementsAre(80, 100, 160, 180, 200, 210));
  EXPECT_THAT(Places(reversed.AsPlayed(filed)), ElementsAre(220, 200, 140, 120, 100, 90));
  const PlayOrder twice(kFileTimes, {false, 2});
  EXPECT_THAT(Times(twice.AsPlayed(filed)),
              ElementsAre(90, 100, 120, 140, 200, 260, 280, 300, 310));
  EXPECT_THAT(Places(twice.AsPlayed(filed)),
              ElementsAre(90, 100, 120, 140, 200, 140, 120, 100, 90));
}

TEST(PlayOrder, FileTimesComeBackFromASinglePass) {
  const Trajectory filed = TrajectoryAt({90, 100, 120, 200});
  const PlayOrder reversed(kFileTimes, {true, 1});
  const Trajectory back = reversed.InFileTimes(reversed.AsPlayed(filed));
  EXPECT_EQ(Times(back), Times(filed));
  EXPECT_EQ(Places(back), Places(filed));
}

TEST(PlayOrder, SeveralPassesStayAsTheyWerePlayed) {
  const PlayOrder twice(kFileTimes, {true, 2});
  EXPECT_THAT(Times(twice.InFileTimes(TrajectoryAt({100, 250}))), ElementsAre(100, 250));
}

}  // namespace
}  // namespace prism
