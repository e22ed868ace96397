// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/micro_image_views.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/calibration/calibrate.h"
#include "prism/calibration/distance_error.h"
#include "test/calibration/synthetic_board.h"

namespace prism {
namespace {

PlenopticCamera Keplerian() {
  PlenopticCamera camera = CameraToCalibrate();
  camera.mode = MicroLensMode::kKeplerian;
  camera.main_lens_mla_distance = camera.focal_length + 2.6 * camera.sensor_mla_distance;
  return camera;
}

// Each corner in the micro images around, on a lattice of 23 px, with noise.
std::vector<MicroImageCorner> MicroImages(const std::vector<BoardView>& views, double noise_px) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, noise_px);
  std::vector<MicroImageCorner> corners;
  for (size_t k = 0; k < views.size(); ++k) {
    for (const CornerObservation& corner : views[k].corners) {
      const Eigen::Vector2d chief =
          (corner.px - corner.slope * corner.micro_image_px) / (1 - corner.slope);
      const Eigen::Vector2d first = 23 * (chief / 23).array().round();
      for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        MicroImageCorner seen;
        seen.micro_image_px = first + Eigen::Vector2d(23 * dx, 23 * dy);
        seen.px = (1 - corner.slope) * chief + corner.slope * seen.micro_image_px +
                  Eigen::Vector2d(noise(random), noise(random));
        seen.cluster = corner.corner;
        seen.frame = static_cast<int>(k);
        corners.push_back(seen);
      }
    }
  }
  return corners;
}

SyntheticViews Exact() {
  SyntheticViews what;
  what.count = 12;
  what.nearest_m = 0.6;  // a Keplerian camera has no image of what is nearer than 0.3 m
  what.px_sigma = 1e-6;
  what.slope_sigma = 1e-9;
  what.offset_sigma = 0;
  return what;
}

CalibrationResult CalibrateOn(const PlenopticCamera& truth, const std::vector<BoardView>& views) {
  PlenopticCamera start = truth;
  start.sensor_mla_distance = 0.42e-3;
  start.main_lens_mla_distance =
      start.focal_length - truth.virtual_depth_sign() * 2.3 * start.sensor_mla_distance;
  CalibrateOptions options;
  options.hold_focal_length = true;
  options.distortion = DistortionModel::kNone;
  return Calibrate(CalibrationBoard(), views, start, options);
}

TEST(MicroImageViews, CalibrateACameraOfEitherMode) {
  const CalibrationBoard board;
  for (const PlenopticCamera& truth : {CameraToCalibrate(), Keplerian()}) {
    const auto views =
        ViewsFromMicroImages(board, MicroImages(MakeViews(board, truth, Exact(), 2), 0.3));
    ASSERT_EQ(views.size(), 12u);
    EXPECT_EQ(IsKeplerian(views), truth.mode == MicroLensMode::kKeplerian);
    const CalibrationResult result = CalibrateOn(truth, views);
    ASSERT_EQ(result.problem, "") << ToString(truth.mode);
    for (const double z : {0.5, 1.0, 2.0}) {
      const double w = InverseVirtualDepth(PlenopticProjection(truth), 1 / z);
      const double found = 1 / InverseDepth(PlenopticProjection(result.camera), w);
      EXPECT_NEAR(found / z, 1, 0.01) << ToString(truth.mode) << " " << z;
      EXPECT_LT(std::abs(found / z - 1), 4 * RelativeDistanceSigma(result, z))
          << ToString(truth.mode) << " " << z;
    }
  }
}

TEST(MicroImageViews, TellCornersByTheirLatticeWhereNumbersDoNot) {
  const CalibrationBoard board;
  const PlenopticCamera camera = CameraToCalibrate();
  SyntheticViews far = Exact();
  far.nearest_m = 1;  // all of the board is seen
  auto corners = MicroImages(MakeViews(board, camera, far, 2), 0.2);
  const auto expected = ViewsFromMicroImages(board, corners);
  for (MicroImageCorner& corner : corners) corner.cluster = (corner.cluster * 7 + 3) % 40;
  const auto views = ViewsFromMicroImages(board, corners);
  ASSERT_EQ(views.size(), expected.size());
  const int last = board.num_corners() - 1;
  for (size_t k = 0; k < views.size(); ++k) {
    ASSERT_EQ(views[k].corners.size(), expected[k].corners.size()) << k;
    std::vector<Eigen::Vector2d> found(board.num_corners()), right(board.num_corners());
    for (const auto& corner : views[k].corners) found[corner.corner] = corner.px;
    for (const auto& corner : expected[k].corners) right[corner.corner] = corner.px;
    // As seen, or turned by 180 degrees, which the corners alone do not tell.
    const bool turned = (found[0] - right[0]).norm() > 1;
    for (int i = 0; i <= last; ++i) {
      EXPECT_LT((found[i] - right[turned ? last - i : i]).norm(), 1e-9) << k << " corner " << i;
    }
  }
}

TEST(MicroImageViews, GrossImagesDoNotCount) {
  const CalibrationBoard board;
  const PlenopticCamera camera = CameraToCalibrate();
  auto corners = MicroImages(MakeViews(board, camera, Exact(), 2), 0.05);
  const auto clean = ViewsFromMicroImages(board, corners);
  for (size_t i = 0; i < corners.size(); i += 25) corners[i].px.x() += 4;
  const auto views = ViewsFromMicroImages(board, corners);
  for (size_t k = 0; k < views.size(); ++k) {
    for (size_t i = 0; i < views[k].corners.size(); ++i) {
      EXPECT_NEAR(views[k].corners[i].px.x(), clean[k].corners[i].px.x(), 0.4);
    }
  }
}

}  // namespace
}  // namespace prism
