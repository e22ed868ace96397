// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/lens_table.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "prism/camera/projection.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

// The definition, over all lenses: Eqs. (6)-(8) and the micro image around c_I.
int CountViews(const PlenopticCamera& camera, const Eigen::Vector2d& X, double w, double radius) {
  int count = 0;
  for (int j = -40; j <= 40; ++j) {
    for (int i = -40; i <= 40; ++i) {
      const Eigen::Vector2d c_I =
          camera.micro_lens_grid->MicroImageCenter({i, j}, camera.raw_width, camera.raw_height);
      const Eigen::Vector2d c_ML = MicroLensCenter(camera, c_I);
      const Eigen::Vector2d x_R = ProjectToRaw(camera, {X.x(), X.y(), 1 / w}, c_ML);
      const bool inside = x_R.minCoeff() >= 1 && x_R.maxCoeff() <= camera.raw_width - 2;
      count += inside && (x_R - c_I).norm() <= radius;
    }
  }
  return count;
}

class LensTableOf : public ::testing::TestWithParam<PlenopticCamera> {};

INSTANTIATE_TEST_SUITE_P(Cameras,
                         LensTableOf,
                         ::testing::Values(SmallCamera(),
                                           SmallCamera(320, MicroLensMode::kKeplerian),
                                           SquareCamera()),
                         CameraName);

TEST_P(LensTableOf, ViewsAreExactlyTheLensesWhoseMicroImageHoldsThePoint) {
  const PlenopticCamera& camera = GetParam();
  const LensTable table(camera);
  LensView views[LensTable::kMaxViews];
  for (const double w : {0.2, 0.3, 0.44}) {
    for (double y = 20.3; y < 300; y += 37.7) {
      for (double x = 20.7; x < 300; x += 31.1) {
        const int count = table.ViewsOf(
            static_cast<float>(x), static_cast<float>(y), static_cast<float>(w), 10.0f, 1, views);
        EXPECT_EQ(count, std::min(CountViews(camera, {x, y}, w, 10), LensTable::kMaxViews))
            << "at " << x << ", " << y << ", 1/v = " << w;
      }
    }
  }
}

TEST_P(LensTableOf, ViewsFollowEquationsSixAndSevenAndTheirDerivative) {
  const PlenopticCamera& camera = GetParam();
  const double sign = camera.mode == MicroLensMode::kKeplerian ? -1 : 1;
  const LensTable table(camera);
  LensView views[LensTable::kMaxViews];
  LensView moved[LensTable::kMaxViews];
  const int count = table.ViewsOf(150, 170, 0.3f, 9, 1, views);
  ASSERT_GT(count, 2);
  const int moved_count = table.ViewsOf(150, 170, 0.31f, 11, 1, moved);
  for (int k = 0; k < count; ++k) {
    const Lens& lens = table.lenses()[views[k].lens];
    EXPECT_NEAR(views[k].x, (150 - lens.lens_x) * sign * 0.3 + lens.lens_x, 1e-3);
    EXPECT_NEAR(views[k].y, (170 - lens.lens_y) * sign * 0.3 + lens.lens_y, 1e-3);
    for (int m = 0; m < moved_count; ++m) {
      if (moved[m].lens != views[k].lens) continue;
      EXPECT_NEAR((moved[m].x - views[k].x) / 0.01, views[k].dx, 0.05);
      EXPECT_NEAR((moved[m].y - views[k].y) / 0.01, views[k].dy, 0.05);
    }
  }
}

TEST(LensTable, ViewsAreTheFirstOfTheTypesAskedFor) {
  const LensTable table(SmallCamera());
  LensView all[LensTable::kMaxViews], some[LensTable::kMaxViews];
  const int count = table.ViewsOf(150, 170, 0.2f, 9, 1, all);
  for (const unsigned types : {1u, 2u, 5u, LensTable::kAllTypes}) {
    const int some_count = table.ViewsOf(150, 170, 0.2f, 9, 1, types, 3, some);
    int expected = 0;
    for (int k = 0; k < count && expected < 3; ++k) {
      if ((types >> table.lenses()[all[k].lens].type & 1u) == 0) continue;
      ASSERT_LT(expected, some_count);
      EXPECT_EQ(some[expected].lens, all[k].lens);
      ++expected;
    }
    EXPECT_EQ(some_count, expected) << types;
  }
}

TEST(LensTable, NeighboursComeByBaselineAndAreMutual) {
  const LensTable table(SmallCamera());
  const auto& lenses = table.lenses();
  const auto baseline = [&](int a, int b) {
    return std::hypot(lenses[a].center_x - lenses[b].center_x,
                      lenses[a].center_y - lenses[b].center_y);
  };
  const float longest = 3.1f * table.pitch_px();
  for (int lens = 0; lens < static_cast<int>(lenses.size()); ++lens) {
    const std::vector<int> neighbours = table.NeighboursOf(lens, longest);
    int expected = 0;
    for (int other = 0; other < static_cast<int>(lenses.size()); ++other) {
      expected += other != lens && baseline(lens, other) <= longest;
    }
    EXPECT_EQ(static_cast<int>(neighbours.size()), expected) << "lens " << lens;
    double previous = 0;
    for (const int neighbour : neighbours) {
      ASSERT_NE(neighbour, lens);
      EXPECT_GE(baseline(lens, neighbour), previous - 1e-3) << lens << " to " << neighbour;
      previous = baseline(lens, neighbour);
      const std::vector<int> back = table.NeighboursOf(neighbour, longest);
      EXPECT_EQ(std::count(back.begin(), back.end(), lens), 1) << lens << " to " << neighbour;
    }
  }
}

TEST(LensTable, LensesAroundHoldAllViewsOfTheirPoints) {
  PlenopticCamera distorted = SmallCamera();
  distorted.distortion.A0 = 2000;
  const PlenopticCamera keplerian = SmallCamera(320, MicroLensMode::kKeplerian);
  for (const PlenopticCamera& camera : {SmallCamera(), distorted, keplerian, SquareCamera()}) {
    const LensTable table(camera);
    std::mt19937_64 generator = SeededGenerator(3, 0);
    std::uniform_real_distribution<float> position(5, 315), depth(0.1f, 0.48f), part(0, 1);
    int views_checked = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      const float X0 = position(generator);
      const float X1 = X0 + 14 * part(generator);
      const float Y = position(generator);
      const float w0 = depth(generator);
      const float w1 = std::min(w0 + 0.05f * part(generator), 0.5f);
      constexpr int kMaxLenses = 400;
      int around[kMaxLenses];
      const int count = table.LensesAround(X0, X1, Y, Y, w0, w1, 10, kMaxLenses, around);
      LensView views[LensTable::kMaxViews];
      const float X = X0 + (X1 - X0) * part(generator);
      const float w = w0 + (w1 - w0) * part(generator);
      const int view_count = table.ViewsOf(X, Y, w, 10, 1, views);
      for (int k = 0; k < view_count; ++k) {
        EXPECT_EQ(std::count(around, around + count, views[k].lens), 1)
            << "trial " << trial << ": " << X << ", " << Y << ", 1/v = " << w << ", lens "
            << views[k].lens << " among " << count;
      }
      views_checked += view_count;
    }
    EXPECT_GT(views_checked, 5000);
  }
}

TEST(LensTable, RowsAroundHoldAllViewsOfTheirPointsAndNotManyMore) {
  for (const MicroLensMode mode : {MicroLensMode::kGalilean, MicroLensMode::kKeplerian}) {
    PlenopticCamera camera = SmallCamera(1024, mode);
    camera.distortion.A0 = 200;
    camera.distortion.B0 = 2;
    const LensTable table(camera);
    std::mt19937_64 generator = SeededGenerator(4, 0);
    std::uniform_real_distribution<float> position(0, 1023), depth(0.05f, 0.48f), part(0, 1);
    int views_checked = 0;
    for (int trial = 0; trial < 300; ++trial) {
      const float Y0 = position(generator), Y1 = Y0 + 100 * part(generator);
      const float w0 = depth(generator), w1 = w0 + (0.5f - w0) * part(generator);
      const LensTable::RowsOfViews rows = table.RowsAround(Y0, Y1, w0, w1, 10);
      float first = 2000, last = -1000;
      for (int point = 0; point < 200; ++point) {
        LensView views[LensTable::kMaxViews];
        const float Y = point % 3 == 0   ? Y0
                        : point % 3 == 1 ? Y1
                                         : Y0 + (Y1 - Y0) * part(generator);
        const float w = point % 5 == 0 ? w0 : w0 + (w1 - w0) * part(generator);
        const int count = table.ViewsOf(position(generator), Y, w, 10, 0, views);
        views_checked += count;
        for (int k = 0; k < count; ++k) {
          first = std::min(first, views[k].y);
          last = std::max(last, views[k].y);
          EXPECT_LE(std::hypot(views[k].dx, views[k].dy), rows.longest_motion);
        }
      }
      ASSERT_GE(first, rows.first)
          << "trial " << trial << ": " << Y0 << " to " << Y1 << ", 1/v " << w0 << " to " << w1;
      ASSERT_LE(last, rows.last);
      EXPECT_LT(rows.last - rows.first, 850)
          << Y0 << " to " << Y1 << ", 1/v " << w0 << " to " << w1;
    }
    EXPECT_GT(views_checked, 100000);
    // The pole of a Keplerian camera: points between its micro lenses and the sensor.
    const bool is_bounded = std::isfinite(table.RowsAround(0, 10, 0.001f, 0.4f, 10).last);
    EXPECT_EQ(is_bounded, mode == MicroLensMode::kGalilean);
  }
}

TEST_P(LensTableOf, ColoursOfNeighboursDiffer) {
  const LensTable table(GetParam());
  for (const Lens& a : table.lenses()) {
    for (const Lens& b : table.lenses()) {
      const double distance = std::hypot(a.image_x - b.image_x, a.image_y - b.image_y);
      if (distance > 1 && distance < 1.2 * table.pitch_px()) {
        EXPECT_NE(a.colour, b.colour);
      }
    }
  }
}

}  // namespace
}  // namespace prism
