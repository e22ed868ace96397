// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/grid_estimation.h"

#include <gtest/gtest.h>

#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

double LargestDistance(const MicroLensGrid& a, const MicroLensGrid& b, int size) {
  double largest = 0;
  for (double y = 20; y < size - 20; y += 17) {
    for (double x = 20; x < size - 20; x += 17) {
      const Eigen::Vector2d center =
          a.MicroImageCenter(a.NearestLens({x, y}, size, size), size, size);
      const Eigen::Vector2d other =
          b.MicroImageCenter(b.NearestLens(center, size, size), size, size);
      largest = std::max(largest, (center - other).norm());
    }
  }
  return largest;
}

ImageF White(const PlenopticCamera& camera) {
  return MeanImage({RenderPlane(
      camera, 0.3, [](double, double) { return 200; }, 3, true)});
}

TEST(GridEstimation, FindsTheGridInAWhiteImageFromNothing) {
  const PlenopticCamera camera = SmallCamera(512);
  const auto fit = EstimateGrid(White(camera));
  ASSERT_TRUE(fit);
  EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.02);
}

TEST(GridEstimation, FindsColumns) {
  PlenopticCamera camera = SmallCamera(512);
  camera.micro_lens_grid->base_x = {0, 1};
  camera.micro_lens_grid->base_y = {0.86602540378443864676, 0.5};
  camera.micro_lens_grid->rotation = -0.003;
  const auto fit = EstimateGrid(White(camera));
  ASSERT_TRUE(fit);
  EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.02);
}

TEST(GridEstimation, RefinementCorrectsTheSignOfTheRotation) {
  const PlenopticCamera camera = SmallCamera(512);
  MicroLensGrid start = *camera.micro_lens_grid;
  start.rotation *= -1;
  start.offset_px += Eigen::Vector2d(0.4, -0.3);
  const auto fit = RefineGrid(White(camera), start);
  ASSERT_TRUE(fit);
  EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.02);
}

TEST(GridEstimation, NoPatternGivesNothing) {
  EXPECT_FALSE(EstimateGrid(ImageF(256, 256, 100.0f)));
}

}  // namespace
}  // namespace prism
