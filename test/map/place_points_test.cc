// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_points.h"

#include <gtest/gtest.h>

#include "test/map/speckle_texture.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

PlenopticProjection Camera() { return PlenopticProjection(SyntheticCamera(SyntheticOptions())); }

// With depths that are true, at every pixel.
LightFieldFrame View(const SE3& pose) {
  std::mt19937_64 generator = SeededGenerator(5, 0);
  return *RenderPlane(Camera(), pose, 2, &generator, SpeckleTexture);
}

SE3 Elsewhere() { return SE3::Exp((Vector6d() << -0.1, 0.05, -0.15, 0, -0.05, 0.1).finished()); }

Place PlaceWith(const std::vector<ReferencePoint>& points, double rho_sigma) {
  Place place;
  for (const ReferencePoint& point : points) {
    place.points.push_back({static_cast<float>(point.px.x()),
                            static_cast<float>(point.px.y()),
                            static_cast<float>(point.rho),
                            static_cast<float>(rho_sigma)});
  }
  return place;
}

std::vector<ReferencePoint> MeasuredIn(const LightFieldFrame& frame, double depth_offset = 0) {
  std::vector<ReferencePoint> points;
  AddMeasuredPoints(Camera(), frame, depth_offset, 400, {}, &points);
  return points;
}

float DepthAt(const LightFieldFrame& frame, const ReferencePoint& point) {
  return frame.inverse_virtual_depth(static_cast<int>(std::lround(point.px.x())),
                                     static_cast<int>(std::lround(point.px.y())));
}

TEST(PlacePoints, AreSeenFromElsewhereWhereTheyAre) {
  const Place place = PlaceWith(MeasuredIn(View(SE3())), 0.01);
  const LightFieldFrame frame = View(Elsewhere());
  std::vector<ReferencePoint> points;
  AddSeenPoints(Camera(), frame, 0, PointsSeenFrom(Camera(), place, Elsewhere()), &points);
  ASSERT_GT(points.size(), 200u);
  for (const ReferencePoint& point : points) {
    EXPECT_NEAR(InverseVirtualDepth(Camera(), point.rho), DepthAt(frame, point), 0.002);
    // 0.15 m nearer than before: the same error of depth is larger in 1/m.
    EXPECT_GT(point.rho_sigma, 0.01);
    EXPECT_LT(point.rho_sigma, 0.02);
  }
}

TEST(PlacePoints, AreHiddenWhereTheFrameMeasuresAnotherDepth) {
  const Place place = PlaceWith(MeasuredIn(View(SE3())), 0.001);
  LightFieldFrame frame = View(SE3());
  for (int y = 0; y < frame.sigma.height(); ++y) {
    for (int x = 0; x < frame.sigma.width() / 2; ++x) frame.inverse_virtual_depth(x, y) += 0.05F;
  }
  std::vector<ReferencePoint> points;
  AddSeenPoints(Camera(), frame, 0, PointsSeenFrom(Camera(), place, SE3()), &points);
  EXPECT_GT(points.size(), 100u);
  for (const ReferencePoint& point : points) EXPECT_GE(point.px.x(), frame.sigma.width() / 2 - 1);
}

TEST(PlacePoints, AreAddedAwayFromOthers) {
  const LightFieldFrame frame = View(SE3());
  std::vector<ReferencePoint> points = MeasuredIn(frame);
  const size_t first = points.size();
  AddSeenPoints(Camera(), frame, 0, points, &points);
  EXPECT_EQ(points.size(), first) << "they are there";
  AddMeasuredPoints(Camera(), frame, 0, static_cast<int>(first), {}, &points);
  EXPECT_EQ(points.size(), first) << "enough of them";
  AddMeasuredPoints(Camera(), frame, 0, static_cast<int>(first) + 100, {}, &points);
  EXPECT_GT(points.size(), first);
  EXPECT_LE(points.size(), first + 130);
  for (size_t i = first; i < points.size(); ++i) {
    for (size_t j = 0; j < first; ++j) EXPECT_GE((points[i].px - points[j].px).norm(), 5);
  }
}

TEST(PlacePoints, KnownDepthsReplaceWhatIsLessCertain) {
  constexpr double kOffset = 0.003;
  LightFieldFrame frame = View(SE3());
  const std::vector<ReferencePoint> seen =
      PointsSeenFrom(Camera(), PlaceWith(MeasuredIn(frame), 0.001), SE3());
  const int middle = frame.sigma.width() / 2;
  for (int y = 0; y < frame.sigma.height(); ++y) {
    for (int x = 0; x < frame.sigma.width(); ++x) {
      frame.sigma(x, y) = x < middle ? 0.01F : 1e-5F;
      frame.inverse_virtual_depth(x, y) += static_cast<float>(kOffset) + (x < middle ? 0.01F : 0);
    }
  }
  const LightFieldFrame known = WithKnownDepths(Camera(), frame, kOffset, seen);
  const LightFieldFrame truth = View(SE3());
  int replaced = 0;
  for (const ReferencePoint& point : seen) {
    const bool is_known = point.px.x() < middle - 2;
    if (!is_known && point.px.x() < middle + 2) continue;
    EXPECT_NEAR(DepthAt(known, point), DepthAt(truth, point) + kOffset, 1e-4);
    replaced += is_known;
  }
  EXPECT_GT(replaced, 100);
}

}  // namespace
}  // namespace prism
