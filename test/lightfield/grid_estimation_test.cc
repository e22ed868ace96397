// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/grid_estimation.h"

#include <algorithm>
#include <cmath>

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

// Micro images darker towards the corners of the sensor, down to a quarter, as natural vignetting
// makes them: each as a whole, by its chief ray.
ImageF ShadedWhite(const PlenopticCamera& camera) {
  ImageF white = White(camera);
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  const int size = white.width();
  const double middle = 0.5 * (size - 1);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Eigen::Vector2d center =
          grid.MicroImageCenter(grid.NearestLens({x, y}, size, size), size, size);
      const double squared = (center.array() - middle).square().sum();
      white(x, y) *= static_cast<float>(1 - 0.75 * squared / (2 * middle * middle));
    }
  }
  return white;
}

// A frame of a scene that is brighter on the right and has edges, in micro images with soft rims
// and dark gaps between them.
ImageF FrameWithDarkGaps(const PlenopticCamera& camera) {
  const auto scene = [](double X, double Y) {
    const double edges = std::sin(0.05 * X + 0.02 * Y) > 0.3 ? 25 : 0;
    return std::clamp(20 + 0.4 * X, 10.0, 220.0) + edges + 10 * std::sin(0.13 * Y);
  };
  ImageF frame = MeanImage({RenderPlane(camera, 0.3, scene, 2)});
  const int size = frame.width();
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Eigen::Vector2d pixel(x, y);
      const MicroLensGrid& grid = *camera.micro_lens_grid;
      const double radius =
          (pixel - grid.MicroImageCenter(grid.NearestLens(pixel, size, size), size, size)).norm();
      frame(x, y) *= static_cast<float>(0.1 + 0.9 / (1 + std::exp((radius - 10.2) / 0.6)));
    }
  }
  return frame;
}

PlenopticCamera CameraWithGrid(bool columns, double rotation) {
  PlenopticCamera camera = SmallCamera(512);
  if (columns) {
    camera.micro_lens_grid->base_x = {0, 1};
    camera.micro_lens_grid->base_y = {0.86602540378443864676, 0.5};
  }
  camera.micro_lens_grid->rotation = rotation;
  return camera;
}

TEST(GridEstimation, FindsTheGridInAWhiteImageFromNothing) {
  const PlenopticCamera camera = SmallCamera(512);
  const auto fit = EstimateGrid(White(camera));
  ASSERT_TRUE(fit);
  EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.02);
}

TEST(GridEstimation, FindsRowsAndColumnsTurnedEitherWayUnderShading) {
  for (const bool columns : {false, true}) {
    for (const double rotation : {-0.003, 0.0007, 0.02}) {
      const PlenopticCamera camera = CameraWithGrid(columns, rotation);
      const auto fit = EstimateGrid(ShadedWhite(camera));
      ASSERT_TRUE(fit) << "columns " << columns << ", rotation " << rotation;
      EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.02)
          << "columns " << columns << ", rotation " << rotation;
    }
  }
}

TEST(GridEstimation, FindsSquareArrays) {
  for (const double rotation : {-0.01, 0.0, 0.3}) {
    PlenopticCamera camera = SquareCamera(512);
    camera.micro_lens_grid->rotation = rotation;
    const auto fit = EstimateGrid(ShadedWhite(camera));
    ASSERT_TRUE(fit) << rotation;
    EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.02) << rotation;
    EXPECT_NEAR(fit->grid.base_x.dot(fit->grid.base_y), 0, 1e-9);
  }
}

TEST(GridEstimation, FindsHexagonalAndSquareArraysInFrames) {
  for (const PlenopticCamera& camera : {CameraWithGrid(true, 0.004), SquareCamera(512)}) {
    const auto fit = EstimateGridOnFrames(FrameWithDarkGaps(camera));
    ASSERT_TRUE(fit);
    EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.1);
  }
}

TEST(GridEstimation, FindsNoGridWhereThereIsNone) {
  const auto scene = [](double X, double Y) { return WavyTexture(0.3 * X, 0.3 * Y); };
  ImageF image(512, 512);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 512; ++x) image(x, y) = static_cast<float>(scene(x, y));
  }
  EXPECT_FALSE(EstimateGrid(image));
  EXPECT_FALSE(EstimateGridOnFrames(image));
}

TEST(GridEstimation, WhatTheSceneShowsDoesNotMoveTheGrid) {
  struct Start {
    Eigen::Vector2d offset_px;
    double rotation, pitch;
  };
  for (const bool columns : {false, true}) {
    const PlenopticCamera camera = CameraWithGrid(columns, 0.002);
    const ImageF frame = FrameWithDarkGaps(camera);
    for (const Start& start : {Start{{0, 0}, 0, 1},
                               Start{{2, -2}, 0.001, 1.0002},
                               Start{{-2, 2}, -0.001, 0.9998},
                               Start{{2, 2}, -0.004, 1}}) {
      MicroLensGrid perturbed = *camera.micro_lens_grid;
      perturbed.offset_px += start.offset_px;
      perturbed.rotation += start.rotation;
      perturbed.diameter_px *= start.pitch;
      const auto fit = RefineGridOnFrames(frame, perturbed);
      ASSERT_TRUE(fit);
      EXPECT_LT(LargestDistance(*camera.micro_lens_grid, fit->grid, 512), 0.1)
          << "columns " << columns << ", start " << start.offset_px.transpose() << " "
          << start.rotation << " " << start.pitch;
      EXPECT_EQ(fit->rotation_flipped, start.rotation == -0.004);
    }
  }
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
  const auto fit = RefineGridOnFrames(ImageF(256, 256, 100.0f), *SmallCamera(256).micro_lens_grid);
  EXPECT_TRUE(!fit || fit->contrast < 0.01);
}

}  // namespace
}  // namespace prism
