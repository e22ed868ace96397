// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/calibrate.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/calibration/distance_error.h"
#include "prism/camera/projection.h"
#include "test/calibration/synthetic_board.h"

namespace prism {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

// What an owner knows: the engraved focal length, and that B is some 0.4 mm.
PlenopticCamera Guess() {
  PlenopticCamera camera = CameraToCalibrate();
  camera.focal_length = 16e-3;
  camera.sensor_mla_distance = 0.4e-3;
  camera.main_lens_mla_distance = camera.focal_length - 2.2 * camera.sensor_mla_distance;
  camera.raw_principal_point = {1023.5, 1023.5};
  return camera;
}

// z' / z - 1 of a point at z, with the true camera's virtual depth.
double DistanceError(const PlenopticCamera& truth, const PlenopticCamera& found, double z) {
  const double w = InverseVirtualDepth(PlenopticProjection(truth), 1 / z);
  return 1 / (InverseDepth(PlenopticProjection(found), w) * z) - 1;
}

TEST(Calibrate, FindsTheCameraFromWhatAnOwnerKnows) {
  const CalibrationBoard board;
  SyntheticViews exact;
  exact.px_sigma = 1e-4;
  exact.slope_sigma = 1e-7;
  exact.offset_sigma = 0;
  const PlenopticCamera truth = CameraToCalibrate();
  const CalibrationResult result =
      Calibrate(board, MakeViews(board, truth, exact, 1), Guess(), CalibrateOptions());
  EXPECT_EQ(result.problem, "");
  EXPECT_NEAR(result.camera.focal_length, truth.focal_length, 1e-7);
  EXPECT_NEAR(result.camera.main_lens_mla_distance, truth.main_lens_mla_distance, 1e-7);
  EXPECT_NEAR(result.camera.sensor_mla_distance, truth.sensor_mla_distance, 1e-8);
  EXPECT_LT((result.camera.raw_principal_point - truth.raw_principal_point).norm(), 0.05);
  for (const double z : {0.5, 1.0, 5.0})
    EXPECT_NEAR(DistanceError(truth, result.camera, z), 0, 1e-4);
}

TEST(Calibrate, TruthIsWithinStatedDeviations) {
  const CalibrationBoard board;
  PlenopticCamera truth = CameraToCalibrate();
  truth.distortion.A0 = -200;
  truth.distortion.A1 = 1e6;  // 1 px at the middle of the rim: too little to be seen by itself
  int within = 0, all = 0;
  double squares = 0;
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    const auto views = MakeViews(board, truth, SyntheticViews(), seed);
    const CalibrationResult result = Calibrate(board, views, Guess(), CalibrateOptions());
    ASSERT_EQ(result.problem, "") << "seed " << seed;
    EXPECT_FALSE(result.held[kRadial0]) << "seed " << seed;
    EXPECT_FALSE(result.held[kRadial1]) << "seed " << seed;
    const CameraFigures figures = FiguresOf(result);
    const double expected[] = {truth.focal_length,
                               truth.main_lens_mla_distance,
                               truth.sensor_mla_distance,
                               truth.raw_principal_point.x(),
                               truth.raw_principal_point.y(),
                               truth.distortion.A0,
                               truth.distortion.A1};
    for (int i = 0; i <= kRadial1; ++i) {
      const double error = (figures.figures[i].value - expected[i]) / figures.figures[i].sigma;
      within += std::abs(error) <= 2.5;
      squares += error * error;
      ++all;
    }
    for (const double z : {0.5, 1.0, 2.0, 5.0}) {
      EXPECT_LT(std::abs(DistanceError(truth, result.camera, z)),
                4 * RelativeDistanceSigma(result, z))
          << "seed " << seed << ", " << z << " m";
    }
  }
  EXPECT_GE(within, 0.9 * all);
  const double rms = std::sqrt(squares / all);
  EXPECT_GT(rms, 0.6);
  EXPECT_LT(rms, 1.4);
}

TEST(Calibrate, LeftOutViewsAreAsWrongAsStated) {
  const CalibrationBoard board;
  double squares = 0;
  int count = 0;
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    const auto views = MakeViews(board, CameraToCalibrate(), SyntheticViews(), seed);
    const CalibrationResult result = Calibrate(board, views, Guess(), CalibrateOptions());
    for (const LeftOutView& view : LeaveOneOut(board, result)) {
      squares += std::pow(view.relative_error / view.sigma, 2);
      ++count;
    }
  }
  EXPECT_EQ(count, 80);
  const double rms = std::sqrt(squares / count);
  EXPECT_GT(rms, 0.7);
  EXPECT_LT(rms, 1.35);
}

TEST(Calibrate, GrossCornersAreLeftOut) {
  const CalibrationBoard board;
  auto views = MakeViews(board, CameraToCalibrate(), SyntheticViews(), 3);
  const CalibrationResult clean = Calibrate(board, views, Guess(), CalibrateOptions());
  for (size_t k = 0; k < views.size(); k += 3) {
    views[k].corners[0].px.x() += 15;
    views[k].corners[5].slope += 0.03;
  }
  const CalibrationResult result = Calibrate(board, views, Guess(), CalibrateOptions());
  EXPECT_EQ(result.problem, "");
  ASSERT_FALSE(result.findings.empty());
  EXPECT_THAT(result.findings.front(), HasSubstr("outliers"));
  for (const double z : {0.5, 2.0}) {
    EXPECT_NEAR(DistanceError(clean.camera, result.camera, z), 0, 0.001);
  }
}

TEST(Calibrate, BoardsParallelToTheSensorDoNotTellTheFocalLength) {
  const CalibrationBoard board;
  SyntheticViews flat;
  flat.max_tilt = 0;
  const auto views = MakeViews(board, CameraToCalibrate(), flat, 1);
  const CalibrationResult refused = Calibrate(board, views, Guess(), CalibrateOptions());
  EXPECT_THAT(refused.problem, HasSubstr("tilted"));
  EXPECT_THAT(refused.problem, HasSubstr("f_L"));

  // Held at what is known, distances are right.
  PlenopticCamera start = Guess();
  start.focal_length = CameraToCalibrate().focal_length;
  start.main_lens_mla_distance = start.focal_length - 2.2 * start.sensor_mla_distance;
  CalibrateOptions known;
  known.focal_length_is_known = true;
  const CalibrationResult result = Calibrate(board, views, start, known);
  EXPECT_EQ(result.problem, "");
  EXPECT_TRUE(result.held[kFocalLength]);
  ASSERT_FALSE(result.findings.empty());
  EXPECT_THAT(result.findings.front(), HasSubstr("f_L held"));
  for (const double z : {0.5, 1.0, 2.0}) {
    EXPECT_NEAR(DistanceError(CameraToCalibrate(), result.camera, z), 0, 0.006) << z;
  }
}

TEST(Calibrate, OneDistanceDoesNotTellTheLensesApart) {
  const CalibrationBoard board;
  SyntheticViews near;
  near.nearest_m = 1.0;
  near.farthest_m = 1.02;
  near.max_tilt = 0.05;
  PlenopticCamera start = Guess();
  start.focal_length = CameraToCalibrate().focal_length;
  CalibrateOptions options;
  options.hold_focal_length = true;
  const auto views = MakeViews(board, CameraToCalibrate(), near, 1);
  const CalibrationResult refused = Calibrate(board, views, start, options);
  EXPECT_THAT(refused.problem, HasSubstr("distances"));
}

TEST(Calibrate, DistortionIsFoundWhereItIsAndNotWhereItIsNot) {
  const CalibrationBoard board;
  const PlenopticCamera straight = CameraToCalibrate();
  PlenopticCamera bent = straight;
  bent.distortion = {-300, 2e6, 0.03, -0.02};
  const auto without = Calibrate(
      board, MakeViews(board, straight, SyntheticViews(), 5), Guess(), CalibrateOptions());
  const NamedFigure A0 = FiguresOf(without).figures[kRadial0];
  EXPECT_LT(std::abs(A0.value), 4 * A0.sigma);
  const NamedFigure A1 = FiguresOf(without).figures[kRadial1];
  EXPECT_LT(std::abs(A1.value), 4 * A1.sigma);
  const auto with =
      Calibrate(board, MakeViews(board, bent, SyntheticViews(), 5), Guess(), CalibrateOptions());
  EXPECT_FALSE(with.held[kRadial0]);
  for (const double z : {0.5, 1.0, 2.0}) {
    EXPECT_LT(std::abs(DistanceError(bent, with.camera, z)), 0.003) << z << " m";
  }
  CalibrateOptions all;
  all.distortion = DistortionModel::kFull;
  const auto full = Calibrate(board, MakeViews(board, bent, SyntheticViews(), 5), Guess(), all);
  const CameraFigures figures = FiguresOf(full);
  const double expected[] = {
      bent.distortion.A0, bent.distortion.A1, bent.distortion.B0, bent.distortion.B1};
  for (int i = 0; i < 4; ++i) {
    const NamedFigure& figure = figures.figures[kRadial0 + i];
    EXPECT_LT(std::abs(figure.value - expected[i]), 4 * figure.sigma) << figure.name;
  }
}

// With b_L0 60 um longer, as a turn of the focus ring moves it.
TEST(Calibrate, PicturesOfAnotherFocusAreNamed) {
  const CalibrationBoard board;
  const PlenopticCamera camera = CameraToCalibrate();
  PlenopticCamera refocused = camera;
  refocused.main_lens_mla_distance += 60e-6;
  const auto ours = MakeViews(board, camera, SyntheticViews(), 1);
  const auto others = MakeViews(board, refocused, SyntheticViews(), 2);

  auto few = ours, without = ours;
  for (const int k : {3, 11}) {
    few[k] = others[k];
    few[k].name = "other " + std::to_string(k);
    without[k].corners.clear();
  }
  const CalibrationResult found = Calibrate(board, few, Guess(), CalibrateOptions());
  EXPECT_EQ(found.problem, "");
  ASSERT_FALSE(found.findings.empty());
  EXPECT_THAT(found.findings.front(), HasSubstr("2 of 20 pictures"));
  EXPECT_THAT(found.findings.front(), HasSubstr("(other 3, other 11)"));
  const CalibrationResult expected = Calibrate(board, without, Guess(), CalibrateOptions());
  EXPECT_THAT(expected.findings, Each(Not(HasSubstr("left out:"))));
  EXPECT_EQ(found.camera.main_lens_mla_distance, expected.camera.main_lens_mla_distance);

  auto many = ours;
  for (int k = 0; k < 8; ++k) many[k] = others[k];
  const CalibrationResult refused = Calibrate(board, many, Guess(), CalibrateOptions());
  EXPECT_THAT(refused.problem, HasSubstr("8 of 20 pictures"));
  EXPECT_THAT(refused.problem, HasSubstr("another camera"));
}

TEST(Calibrate, SquaresOfAnotherSizeAreToldByAKnownSensorDistance) {
  CalibrationBoard board;
  CalibrateOptions known;
  known.sensor_distance_is_known = true;
  const auto views = MakeViews(board, CameraToCalibrate(), SyntheticViews(), 1);
  const CalibrationResult right = Calibrate(board, views, CameraToCalibrate(), known);
  EXPECT_THAT(right.findings, Each(Not(HasSubstr("squares"))));
  board.square_m = 0.038;  // they are of 40 mm
  const CalibrationResult wrong = Calibrate(board, views, CameraToCalibrate(), known);
  ASSERT_FALSE(wrong.findings.empty());
  EXPECT_THAT(wrong.findings.back(), HasSubstr("B is 5."));
  EXPECT_THAT(wrong.findings.back(), HasSubstr("larger"));
  EXPECT_THAT(wrong.findings.back(), HasSubstr("not 38.00"));
}

TEST(Calibrate, AWrongBoardIsNotACamera) {
  const CalibrationBoard board;
  auto views = MakeViews(board, CameraToCalibrate(), SyntheticViews(), 1);
  for (BoardView& view : views) view.corners.resize(4);
  const CalibrationResult result = Calibrate(board, views, Guess(), CalibrateOptions());
  EXPECT_THAT(result.problem, HasSubstr("no camera"));
}

}  // namespace
}  // namespace prism
