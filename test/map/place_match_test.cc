// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_match.h"

#include <gtest/gtest.h>

#include "prism/map/place_features.h"
#include "prism/map/place_points.h"
#include "prism/map/place_view.h"
#include "test/map/speckle_texture.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

SyntheticOptions Scene() { return SyntheticOptions(); }
PlenopticCamera Camera() { return SyntheticCamera(Scene()); }

SE3 Pose(double x, double y, double z, double yaw, double roll) {
  return SE3::Exp((Vector6d() << x, y, z, 0, yaw, roll).finished());
}

std::shared_ptr<LightFieldFrame> View(const SE3& pose,
                                      const Texture& texture = SpeckleTexture,
                                      unsigned seed = 0) {
  std::mt19937_64 generator = SeededGenerator(5, seed);
  return RenderPlane(PlenopticProjection(Camera()), pose, 2, &generator, texture);
}

Place KnownPlace(const LightFieldFrame& frame) {
  const PlenopticProjection projection(Camera());
  std::vector<ReferencePoint> points;
  AddMeasuredPoints(projection, frame, 0, 1000, {}, &points);
  return MakePlace(projection, 7, frame, points);
}

std::vector<PlaceMatch> Find(const Place& place, const LightFieldFrame& frame) {
  return FindMatches(Camera(),
                     {&place},
                     MakePlaceQuery(Camera(), frame, {}, {}),
                     NoiseModel(2),
                     0,
                     AlignmentOptions(),
                     PlaceMatchOptions());
}

TEST(PlaceMatch, AViewFromElsewhereIsFoundWhereItIs) {
  const SE3 known = Pose(0, 0, 0, 0, 0);
  const Place place = KnownPlace(*View(known));
  const std::vector<SE3> queries = {Pose(0.1, 0.05, 0, 0.02, 0),
                                    Pose(-0.2, 0.1, 0.15, -0.05, 0.2),
                                    Pose(0.05, -0.1, -0.2, 0.1, -0.4)};
  for (size_t i = 0; i < queries.size(); ++i) {
    const std::vector<PlaceMatch> matches = Find(place, *View(queries[i], SpeckleTexture, 1));
    ASSERT_EQ(matches.size(), 1u) << "view " << i;
    EXPECT_EQ(matches[0].keyframe_id, 7);
    const SE3 error = matches[0].query_from_known * known * queries[i].Inverse();
    EXPECT_LT(error.translation().norm(), 0.005) << "view " << i;
    EXPECT_LT(RotationAngle(error), 0.003) << "view " << i;
    // What the pose is known by agrees with that: an eigenvalue a direction.
    const double distance = error.Log().dot(matches[0].information * error.Log());
    EXPECT_LT(distance, 100) << "view " << i;
    EXPECT_GT(matches[0].information.diagonal().minCoeff(), 1e4);
  }
}

TEST(PlaceMatch, AnotherPartOfTheSceneIsNotFound) {
  const Place place = KnownPlace(*View(Pose(0, 0, 0, 0, 0)));
  EXPECT_TRUE(Find(place, *View(Pose(3, 2, 0, 0, 0))).empty());
}

// Walls repeat; what hangs on them does not.
TEST(PlaceMatch, APlaceThatLooksAlikeButForAnAreaIsNotFound) {
  constexpr double kPeriod = 4;
  const auto wall = [](double x, double y) {
    const double repeated = x - kPeriod * std::floor(x / kPeriod);
    const bool is_picture = repeated > 1.7 && repeated < 2.3 && std::abs(y) < 0.3;
    return is_picture ? SpeckleTexture(x + 50, y) : SpeckleTexture(repeated, y);
  };
  const auto same = [](double x, double y) {
    return SpeckleTexture(x - kPeriod * std::floor(x / kPeriod), y);
  };
  const SE3 here = Pose(-2, 0, 0, 0, 0);
  // The plane is inclined: one period on, it is nearer or farther by 0.2 of it.
  const SE3 there = Pose(-2 - kPeriod, 0, -0.2 * kPeriod, 0, 0);
  const Place place = KnownPlace(*View(here, wall));
  EXPECT_TRUE(Find(place, *View(there, wall, 1)).empty());
  EXPECT_EQ(Find(place, *View(here, wall, 1)).size(), 1u);
  // Without the picture nothing can tell.
  EXPECT_EQ(Find(KnownPlace(*View(here, same)), *View(there, same, 1)).size(), 1u);
}

// A camera before a poster of the scene, twice as near and half as large, sees the same image.
TEST(PlaceMatch, ASmallCopyIsToldByItsDepth) {
  const Place place = KnownPlace(*View(Pose(0, 0, 0, 0, 0)));
  const PlenopticProjection projection(Camera());
  LightFieldFrame copy = *View(Pose(0.05, 0, 0, 0, 0));
  for (size_t i = 0; i < copy.sigma.size(); ++i) {
    const double rho = InverseDepth(projection, copy.inverse_virtual_depth.data()[i]);
    copy.inverse_virtual_depth.data()[i] =
        static_cast<float>(InverseVirtualDepth(projection, 2 * rho));
  }
  EXPECT_TRUE(Find(place, copy).empty());
}

TEST(PlaceFeatures, GiveThePoseRoughly) {
  const PlenopticProjection projection(Camera());
  const SE3 query_pose = Pose(-0.2, 0.1, 0.15, -0.05, 0.5);
  const Place known = KnownPlace(*View(SE3()));
  const Place query = KnownPlace(*View(query_pose));
  const std::vector<FeatureMatch> matches = MatchFeatures(query, known);
  const auto pose = EstimateFeaturePose(projection, query, known, matches, 8);
  ASSERT_TRUE(pose.has_value()) << matches.size() << " matches";
  EXPECT_LT((pose->query_from_known * query_pose.Inverse()).Log().norm(), 0.05);
  EXPECT_FALSE(EstimateFeaturePose(projection, query, known, {}, 8).has_value());
}

}  // namespace
}  // namespace prism
