// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/map.h"

#include <gtest/gtest.h>

#include "test/window/synthetic_window.h"

namespace prism {
namespace {

SE3 Shift(double x) { return SE3(Eigen::Quaterniond::Identity(), {x, 0, 0}); }

// A window of one keyframe without points, in the coordinates of its segment.
Window WindowWith(int id, const SE3& cam_from_segment) {
  Window window{PlenopticProjection(SyntheticCamera(SyntheticOptions()))};
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->id = id;
  keyframe->state = FrameState(cam_from_segment, 0, 0);
  auto frame = std::make_shared<LightFieldFrame>();
  frame->time_ns = id;
  keyframe->frame = frame;
  window.keyframes.push_back(std::move(keyframe));
  return window;
}

void AddKeyframe(int segment, int id, double x, Map* map) {
  map->RememberKeyframes(WindowWith(id, Shift(-x)), segment);
  map->AddFrame(id, id, SE3());
}

double PositionOf(const Map& map, int id) {
  return map.CamFromWorld(id).Inverse().translation().x();
}

TEST(Map, WhatBeganLaterIsMovedAsAWhole) {
  Map map(10);
  map.StartSegment(0, SE3());
  AddKeyframe(0, 0, 0.5, &map);
  map.StartSegment(1, Shift(10));
  AddKeyframe(1, 1, 0, &map);
  map.StartSegment(2, Shift(20));
  AddKeyframe(2, 2, 0.25, &map);
  EXPECT_EQ(map.Pieces(), (std::vector<int>{0, 1, 2}));
  // Segment 2 is found 1 m behind segment 1, then segment 1 in segment 0.
  map.Join(2, 1, Shift(11));
  EXPECT_EQ(map.Pieces(), (std::vector<int>{0, 1}));
  EXPECT_NEAR(PositionOf(map, 2), 11.25, 1e-12);
  EXPECT_EQ(map.FrameTrajectory(1).size(), 2u);
  const SE3 moved = map.Join(1, 0, Shift(2));
  EXPECT_NEAR(moved.translation().x(), -8, 1e-12);
  EXPECT_EQ(map.Pieces(), (std::vector<int>{0}));
  EXPECT_NEAR(PositionOf(map, 0), 0.5, 1e-12);
  EXPECT_NEAR(PositionOf(map, 1), 2, 1e-12);
  EXPECT_NEAR(PositionOf(map, 2), 3.25, 1e-12);
}

TEST(Map, AnEarlierPieceFoundInALaterOneStaysAndTheLaterOneMoves) {
  Map map(10);
  map.StartSegment(0, SE3());
  AddKeyframe(0, 0, 0, &map);
  map.StartSegment(1, Shift(10));
  AddKeyframe(1, 1, 0, &map);
  map.Join(0, 1, Shift(9));  // segment 0 is 1 m before segment 1
  EXPECT_NEAR(PositionOf(map, 0), 0, 1e-12);
  EXPECT_NEAR(PositionOf(map, 1), 1, 1e-12);
  EXPECT_EQ(map.Piece(1), 0);
}

TEST(Map, LoadedPlacesAreNoPartOfTheRunButItsWorldOnceJoined) {
  Map map(10);
  MappedPlace known;
  known.place.keyframe_id = 4;
  known.cam_from_world = Shift(-7);
  map.Load({known});
  map.StartSegment(0, SE3());
  AddKeyframe(0, 5, 0, &map);
  EXPECT_EQ(map.KeyframeTrajectory().size(), 1u);
  map.Join(0, kLoadedSegment, Shift(6));
  EXPECT_NEAR(PositionOf(map, 4), 7, 1e-12);
  EXPECT_NEAR(PositionOf(map, 5), 6, 1e-12);
  EXPECT_EQ(map.MappedPlaces(kLoadedSegment).size(), 1u);
}

TEST(Map, KnowsThePlaceBeforeAKeyframeInItsSegment) {
  Map map(10);
  for (int id = 0; id < 4; ++id) {
    const int segment = id / 3;
    if (id % 3 == 0) map.StartSegment(segment, SE3());
    AddKeyframe(segment, id, id, &map);
  }
  for (const int id : {0, 2}) {
    Place place;
    place.keyframe_id = id;
    map.AddPlace(place);
  }
  EXPECT_EQ(map.PlaceBefore(0, 0), nullptr);
  ASSERT_NE(map.PlaceBefore(0, 2), nullptr);
  EXPECT_EQ(map.PlaceBefore(0, 2)->keyframe_id, 0);
  EXPECT_EQ(map.PlaceBefore(1, 3), nullptr) << "of another segment";
}

TEST(Map, OfTheClosestPlacesTheYoungerIsForgotten) {
  Map map(3);
  map.StartSegment(0, SE3());
  const double positions[] = {0, 1, 1.1, 3};
  for (int id = 0; id < 4; ++id) {
    AddKeyframe(0, id, positions[id], &map);
    Place place;
    place.keyframe_id = id;
    place.median_rho = 0.5F;
    map.AddPlace(place);
  }
  EXPECT_EQ(map.places().size(), 3u);
  EXPECT_EQ(map.places().count(2), 0u);
}

}  // namespace
}  // namespace prism
