// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/calibration/board_observation.h"

#include <cmath>

#include <glog/logging.h>
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

TEST(BoardDetection, AnotherNumberOfSquaresInARowIsNotTheBoard) {
  const cv::Matx33d map(0.9, 0.1, 30, -0.12, 0.95, 90, 2e-4, 1e-4, 1);
  const CalibrationBoard board;
  const ImageF image = Picture(board, map, 760, 600);
  ASSERT_FALSE(DetectBoard(board, image).empty());
  for (const int columns : {7, 8, 10, 11}) {
    CalibrationBoard other = board;
    other.columns = columns;
    EXPECT_TRUE(DetectBoard(other, image).empty()) << columns;
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

// What an owner starts from, and what a light field with it makes of a corner: the virtual point
// whose image moves from micro image to micro image as the true one's does.
class BoardObservationWithAnotherCamera : public ::testing::Test {
 protected:
  BoardObservationWithAnotherCamera() {
    other_.focal_length = 16e-3;
    other_.sensor_mla_distance = 0.43e-3;
    other_.main_lens_mla_distance = other_.focal_length - 2.1 * other_.sensor_mla_distance;
    other_.raw_principal_point = {1000, 1030};
    const double kappa = other_.main_lens_mla_distance /
                         (other_.main_lens_mla_distance + other_.sensor_mla_distance);
    w_ = 1 - exact_.slope / kappa;
    lens_ = MicroLensCenter(other_, exact_.micro_image_px);
    RawAppearance<double> appearance;
    const CameraParameters parameters = ParametersOf(truth_);
    CHECK(Appear(FixedFigures(truth_), parameters.data(), x_C_, &appearance));
    chief_px_ = appearance.chief_px;
    frame_.inverse_virtual_depth = ImageF(1024, 1024, static_cast<float>(w_));
    frame_.sigma = ImageF(1024, 1024, 0.002f);
  }

  void ExpectExact(const BoardView& view) const {
    ASSERT_EQ(view.corners.size(), 1u);
    EXPECT_EQ(view.corners[0].corner, 7);
    EXPECT_NEAR(view.corners[0].slope, exact_.slope, 1e-7);
    EXPECT_LT((view.corners[0].ChiefPx() - chief_px_).norm(), 1e-3);
  }

  const PlenopticCamera truth_ = CameraToCalibrate();
  PlenopticCamera other_ = truth_;
  const Eigen::Vector3d x_C_{0.12, -0.2, 0.9};
  const CornerObservation exact_ = ObserveExactly(truth_, x_C_, 0);
  double w_ = 0;
  Eigen::Vector2d lens_, chief_px_;
  LightFieldFrame frame_;
};

TEST_F(BoardObservationWithAnotherCamera, IsTheTrueOne) {
  const Eigen::Vector2d x_V = (exact_.px - lens_) / w_ + lens_;
  ExpectExact(ObserveCorners({{7, FocusedFromRaw(other_, x_V), 40}}, other_, frame_, ImageF()));
}

// The lens in whose micro image a pixel of chief rays is at the centre shows it there whatever
// depth the image was focused at.
TEST_F(BoardObservationWithAnotherCamera, IsTheTrueOneInImagesOfChiefRaysFocusedAnywhere) {
  other_.focused_image = FocusedImage::kChiefRays;
  const Eigen::Vector2d c = other_.raw_principal_point;
  for (const double focused_at : {w_, w_ + 0.05, w_ - 0.05}) {
    const double b_L =
        other_.main_lens_mla_distance + other_.sensor_mla_distance / focused_at;  // Eq. (4)
    // The virtual point at that depth which the lens at x_0 shows in the middle.
    const Eigen::Vector2d centre = MicroLensCenter(other_, chief_px_);
    const Eigen::Vector2d x_V = (chief_px_ - centre) / focused_at + centre;
    const Eigen::Vector2d pixel = (x_V - c) * other_.focal_length / b_L + c;
    const ImageF dense(1024, 1024, static_cast<float>(focused_at));
    ExpectExact(ObserveCorners({{7, FocusedFromRaw(other_, pixel), 40}}, other_, frame_, dense));
  }
}

}  // namespace
}  // namespace prism
