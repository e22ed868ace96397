// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/joining.h"

#include <gtest/gtest.h>

#include "test/window/synthetic_window.h"

namespace prism {
namespace {

SE3 Pose(double x, double turn) {
  return SE3::Exp((Vector6d() << x, 0.02, -0.1, 0, turn, 0.1).finished());
}

// cam_from_segment of the keyframes of a segment that walks to the side.
SE3 CamFromSegment(int id) { return Pose(-0.1 * id, 0.03 * id); }

Map MapOfOneSegment(int keyframes, const SE3& world_from_segment) {
  Map map(10);
  map.StartSegment(0, world_from_segment);
  for (int id = 0; id < keyframes; ++id) {
    Window window{PlenopticProjection(SyntheticCamera(SyntheticOptions()))};
    auto keyframe = std::make_unique<Keyframe>();
    keyframe->id = id;
    keyframe->state = FrameState(CamFromSegment(id), 0, 0);
    keyframe->frame = std::make_shared<LightFieldFrame>();
    window.keyframes.push_back(std::move(keyframe));
    map.RememberKeyframes(window, 0);
  }
  return map;
}

double Distance(const SE3& left, const SE3& right) { return (left * right.Inverse()).Log().norm(); }

TEST(FitSegment, PutsASegmentWhereItsKeyframesWereFound) {
  const SE3 assumed = Pose(0.3, 0.2), true_place = Pose(0.28, 0.24);
  const Map map = MapOfOneSegment(7, assumed);
  std::vector<Sighting> sightings;
  for (int id = 0; id < 7; ++id) {
    // The first keyframes of a segment know their direction least.
    const SE3 error = SE3::Exp((Vector6d() << 0, 0, 0, 0, id == 0 ? 0.002 : 0, 0).finished());
    sightings.push_back({id, error * CamFromSegment(id) * true_place.Inverse(), 2.0});
  }
  const auto placed = FitSegment(map, 0, sightings);
  ASSERT_TRUE(placed);
  EXPECT_LT(Distance(*placed, true_place), 1e-3);
  EXPECT_GT(Distance(assumed, true_place), 0.03);

  // A match that is wrong is left out.
  sightings[3].cam_from_world = Pose(0.5, 0) * sightings[3].cam_from_world;
  sightings[0].cam_from_world = CamFromSegment(0) * true_place.Inverse();
  const auto without = FitSegment(map, 0, sightings);
  ASSERT_TRUE(without);
  EXPECT_LT(Distance(*without, true_place), 1e-6);
}

TEST(FitSegment, TwoKeyframesAreTooFew) {
  const Map map = MapOfOneSegment(2, SE3());
  EXPECT_FALSE(FitSegment(map, 0, {{0, CamFromSegment(0), 2}, {1, CamFromSegment(1), 2}}));
  EXPECT_FALSE(FitSegment(map, 0, {}));
}

}  // namespace
}  // namespace prism
