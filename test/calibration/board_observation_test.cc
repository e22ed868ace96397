// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/board_observation.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/calibration/board_detection.h"
#include "prism/calibration/camera_model.h"
#include "test/calibration/synthetic_board.h"

namespace prism {
namespace {

// The board under a perspective map, smoothed as an image is; the map takes the drawn board's
// pixels to the image's.
ImageF Picture(const CalibrationBoard& board, const cv::Matx33d& map, int width, int height) {
  constexpr int kFiner = 4;  // drawn finer and averaged: no aliasing
  const double shift = 0.5 * (kFiner - 1);
  const cv::Matx33d finer(kFiner, 0, shift, 0, kFiner, shift, 0, 0, 1);
  cv::Mat warped, averaged;
  cv::warpPerspective(DrawBoard(board, 64, 64),
                      warped,
                      finer * map,
                      {kFiner * width, kFiner * height},
                      cv::INTER_LINEAR,
                      cv::BORDER_CONSTANT,
                      cv::Scalar(180));
  cv::resize(warped, averaged, {width, height}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(averaged, averaged, {}, 0.8);
  ImageF image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = averaged.at<uint8_t>(y, x);
  }
  return image;
}

Eigen::Vector2d Map(const cv::Matx33d& map, const CalibrationBoard& board, int corner) {
  // Edges of the drawing lie between pixels.
  const Eigen::Vector2d p =
      board.CornerPosition(corner).head<2>() / board.square_m * 64 + Eigen::Vector2d(63.5, 63.5);
  const cv::Vec3d q = map * cv::Vec3d(p.x(), p.y(), 1);
  return {q[0] / q[2], q[1] / q[2]};
}

TEST(BoardDetection, FindsCornersToAFractionOfAPixel) {
  const cv::Matx33d maps[] = {{0.9, 0.1, 30, -0.12, 0.95, 90, 2e-4, 1e-4, 1},
                              {0.5, -0.05, 120, 0.06, 0.48, 60, -1e-4, 2e-4, 1}};
  for (const BoardPattern pattern : {BoardPattern::kCharuco, BoardPattern::kCheckerboard}) {
    CalibrationBoard board;
    board.pattern = pattern;
    for (const cv::Matx33d& map : maps) {
      const ImageF image = Picture(board, map, 760, 600);
      const std::vector<DetectedCorner> corners = DetectBoard(board, image);
      ASSERT_GE(corners.size(), 36u) << ToString(pattern);
      for (const DetectedCorner& corner : corners) {
        EXPECT_LT((corner.px - Map(map, board, corner.corner)).norm(), 0.15)
            << ToString(pattern) << " corner " << corner.corner;
      }
    }
  }
}

TEST(BoardDetection, NothingWhereThereIsNoBoard) {
  EXPECT_TRUE(DetectBoard(CalibrationBoard(), ImageF(300, 200, 128.0f)).empty());
}

LightFieldFrame FrameOfPlane(int width, int height, double w0, double slope_x) {
  LightFieldFrame frame;
  frame.inverse_virtual_depth = ImageF(width, height);
  frame.sigma = ImageF(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if ((x * 7 + y * 13) % 5 != 0) continue;
      frame.inverse_virtual_depth(x, y) = static_cast<float>(w0 + slope_x * (x - 50));
      frame.sigma(x, y) = 0.002f;
    }
  }
  return frame;
}

TEST(LocalDepth, FollowsAPlaneAndLeavesOutGrossErrors) {
  LightFieldFrame frame = FrameOfPlane(101, 101, 0.3, 2e-4);
  for (int y = 40; y < 52; ++y) {
    for (int x = 40; x < 52; ++x) {
      if (frame.sigma(x, y) > 0) frame.inverse_virtual_depth(x, y) = 0.2f;
    }
  }
  const auto depth = FitLocalDepth(frame, {50.3, 50}, 20);
  ASSERT_TRUE(depth);
  EXPECT_NEAR(depth->inverse_virtual_depth, 0.3 + 0.3 * 2e-4, 2e-4);
  EXPECT_GT(depth->sigma, 0);
}

TEST(LocalDepth, AsksForDepthAround) {
  LightFieldFrame frame = FrameOfPlane(101, 101, 0.3, 0);
  for (int y = 0; y < 101; ++y) {
    for (int x = 0; x < 62; ++x) frame.inverse_virtual_depth(x, y) = 0;
  }
  EXPECT_FALSE(FitLocalDepth(frame, {50, 50}, 20));  // all to one side
  EXPECT_FALSE(FitLocalDepth(frame, {20, 50}, 20));  // none
  EXPECT_TRUE(FitLocalDepth(frame, {85, 50}, 15));
}

// What the header promises: whatever camera the light field was made with, the observation is the
// true one.
TEST(BoardObservation, DoesNotDependOnTheCameraTheLightFieldWasMadeWith) {
  const PlenopticCamera truth = CameraToCalibrate();
  PlenopticCamera other = truth;
  other.focal_length = 16e-3;
  other.sensor_mla_distance = 0.43e-3;
  other.main_lens_mla_distance = other.focal_length - 2.1 * other.sensor_mla_distance;
  other.raw_principal_point = {1000, 1030};

  const Eigen::Vector3d x_C(0.12, -0.2, 0.9);
  const CornerObservation exact = ObserveExactly(truth, x_C, 0);
  // What a light field with `other` makes of it: the virtual point whose image moves from micro
  // image to micro image as the true one's does.
  const double kappa =
      other.main_lens_mla_distance / (other.main_lens_mla_distance + other.sensor_mla_distance);
  const double w = 1 - exact.slope / kappa;
  const Eigen::Vector2d lens = MicroLensCenter(other, exact.micro_image_px);
  const Eigen::Vector2d x_V = (exact.px - lens) / w + lens;
  const Eigen::Vector2d focused = FocusedFromRaw(other, x_V);

  LightFieldFrame frame;
  frame.inverse_virtual_depth = ImageF(1024, 1024, static_cast<float>(w));
  frame.sigma = ImageF(1024, 1024, 0.002f);
  const BoardView view = ObserveCorners({{7, focused, 40}}, other, frame, ImageF());
  ASSERT_EQ(view.corners.size(), 1u);
  EXPECT_EQ(view.corners[0].corner, 7);
  EXPECT_NEAR(view.corners[0].slope, exact.slope, 1e-7);
  RawAppearance<double> appearance;
  const CameraParameters parameters = ParametersOf(truth);
  ASSERT_TRUE(Appear(FixedFigures(truth), parameters.data(), x_C, &appearance));
  EXPECT_LT((view.corners[0].px - appearance.chief_px).norm(), 1e-3);
}

}  // namespace
}  // namespace prism
