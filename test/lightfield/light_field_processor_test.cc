// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/light_field_processor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/raw_sequence.h"
#include "prism/lightfield/depth_accuracy.h"
#include "prism/lightfield/focused_image.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

RawFrame Frame(const cv::Mat& image) {
  RawFrame frame;
  frame.time_ns = 5;
  frame.image = image;
  return frame;
}

cv::Mat White(const PlenopticCamera& camera) {
  return RenderPlane(
      camera, 0.3, [](double, double) { return 230; }, 0, true);
}

class ProcessorOnPlanes : public ::testing::TestWithParam<std::tuple<double, PlenopticCamera>> {};

TEST_P(ProcessorOnPlanes, InverseVirtualDepthIsUnbiasedAndTheImageIsTheTexture) {
  const auto& [w, camera] = GetParam();
  LightFieldProcessor processor(camera, White(camera), {});
  const LightFieldFrame frame =
      processor.Process(Frame(RenderPlane(camera, w, WavyTexture, 1.5, true)));
  std::vector<double> errors;
  double image_error = 0;
  int image_count = 0;
  const double gain = 1 / 0.99;  // the bright level is a percentile just below the peak
  for (int y = 30; y < 130; ++y) {
    for (int x = 30; x < 130; ++x) {
      if (frame.sigma(x, y) > 0) errors.push_back(frame.inverse_virtual_depth(x, y) - w);
      const Eigen::Vector2d X = RawFromFocused(camera, {x, y});
      image_error += std::abs(gain * frame.image[0](x, y) - WavyTexture(X.x(), X.y()));
      ++image_count;
    }
  }
  ASSERT_GT(errors.size(), 4000u);
  std::sort(errors.begin(), errors.end());
  EXPECT_NEAR(errors[errors.size() / 2], 0, 0.001);
  EXPECT_LT(errors[errors.size() * 9 / 10] - errors[errors.size() / 10], 0.02);
  EXPECT_LT(image_error / image_count, 6);
}

INSTANTIATE_TEST_SUITE_P(
    Depths,
    ProcessorOnPlanes,
    ::testing::Combine(::testing::Values(0.2, 0.28, 0.36),
                       ::testing::Values(SmallCamera(),
                                         SmallCamera(320, MicroLensMode::kKeplerian),
                                         SquareCamera())));

// Far away two or three lenses see a point, near their rims, and texture is not far above the
// noise.
TEST(Processor, FarWeakTextureIsMeasuredWithoutBias) {
  const PlenopticCamera camera = SmallCamera(640);
  LightFieldProcessor processor(camera, White(camera), {});
  for (const double w : {0.41, 0.425, 0.44}) {
    const auto weak = [](double X, double Y) { return 120 + 0.3 * (WavyTexture(X, Y) - 120); };
    const LightFieldFrame frame = processor.Process(Frame(RenderPlane(camera, w, weak, 3, true)));
    std::vector<double> errors;
    double sum = 0;
    for (size_t i = 0; i < frame.sigma.size(); ++i) {
      if (frame.sigma.data()[i] == 0) continue;
      errors.push_back(frame.inverse_virtual_depth.data()[i] - w);
      sum += errors.back();
    }
    std::sort(errors.begin(), errors.end());
    ASSERT_GT(errors.size(), 40000u);
    EXPECT_NEAR(errors[errors.size() / 2], 0, 0.0003) << w;
    EXPECT_NEAR(sum / static_cast<double>(errors.size()), 0, 0.0004) << w;
  }
}

// With three lens types few lenses see a point, and a little further away none do: what noise makes
// larger must not be what is not found.
TEST(Processor, WhatFewLensesSeeIsMeasuredWithoutBias) {
  PlenopticCamera camera = SmallCamera(640);
  camera.micro_lens_grid->types = {{{0, 0}, 1, 3.2}, {{0, 1}, 2.6, 4.2}, {{0, -1}, 3.5, 100}};
  LightFieldProcessor processor(camera, White(camera), {});
  for (const double w : {0.395, 0.407, 0.415}) {
    const auto weak = [](double X, double Y) { return 120 + 0.5 * (WavyTexture(X, Y) - 120); };
    const LightFieldFrame frame = processor.Process(Frame(RenderPlane(camera, w, weak, 2, true)));
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < frame.sigma.size(); ++i) {
      if (frame.sigma.data()[i] == 0) continue;
      sum += frame.inverse_virtual_depth.data()[i] - w;
      ++count;
    }
    ASSERT_GT(count, 40000);
    EXPECT_NEAR(sum / count, 0, 0.0003) << w;
  }
}

// A bright board with an upright edge before a wall with little texture: beside the edge the
// patches see nothing as well as the edge, whose depth is the board's.
class ProcessorBesideAnEdge : public ::testing::TestWithParam<MicroLensMode> {};

TEST_P(ProcessorBesideAnEdge, DoesNotTakeTheWallForTheBoard) {
  const PlenopticCamera camera = SmallCamera(480, GetParam());
  const bool is_keplerian = camera.mode == MicroLensMode::kKeplerian;
  const double near_w = is_keplerian ? 0.41 : 0.39;
  const double far_w = is_keplerian ? 0.39 : 0.41;
  const auto wall = [](double X, double Y) { return 80 + 0.2 * (WavyTexture(X, Y) - 120); };
  const auto board = [](double X, double Y) { return WavyTexture(X, Y) + 60; };
  const double edge = 240;  // virtual raw px
  cv::Mat raw = RenderPlane(camera, far_w, wall, 1.5, true);
  const cv::Mat near = RenderPlane(camera, near_w, board, 1.5, true);
  RenderPlane(camera, near_w, [&](double X, double) {
    return X < edge ? 255 : 0;
  }).forEach<uint8_t>([&](uint8_t is_board, const int* at) {
    if (is_board != 0) raw.at<uint8_t>(at) = near.at<uint8_t>(at);
  });
  LightFieldProcessor processor(camera, White(camera), {});
  const LightFieldFrame frame = processor.Process(Frame(raw));
  std::vector<double> beside;
  int on_edge = 0;
  const int edge_px = static_cast<int>(edge / camera.focused_scale);
  for (int y = 20; y < 220; ++y) {
    for (int x = edge_px + 4; x < edge_px + 14; ++x) {
      if (frame.sigma(x, y) > 0) beside.push_back(frame.inverse_virtual_depth(x, y));
    }
    on_edge += frame.sigma(edge_px, y) > 0;
  }
  std::sort(beside.begin(), beside.end());
  ASSERT_GT(beside.size(), 200u);
  EXPECT_NEAR(beside[beside.size() / 2], far_w, 0.0022);
  EXPECT_GT(on_edge, 110);
}

INSTANTIATE_TEST_SUITE_P(Modes,
                         ProcessorBesideAnEdge,
                         ::testing::Values(MicroLensMode::kGalilean, MicroLensMode::kKeplerian));

LightFieldOptions WithThreadCount(int threads) {
  LightFieldOptions options;
  options.threads = threads;
  return options;
}

TEST(Processor, ResultDoesNotDependOnTheNumberOfThreadsNorOnFramesBefore) {
  const PlenopticCamera camera = SmallCamera();
  const RawFrame raw = Frame(RenderPlane(camera, 0.3, WavyTexture, 2, true));
  const RawFrame other = Frame(RenderPlane(camera, 0.22, WavyTexture, 2, true));
  LightFieldProcessor one_thread(camera, White(camera), WithThreadCount(1));
  const LightFieldFrame first = one_thread.Process(raw);
  for (const int threads : {0, 1, 2, 5}) {
    LightFieldProcessor processor(camera, White(camera), WithThreadCount(threads));
    processor.Process(other);
    const LightFieldFrame second = processor.Process(raw);
    const size_t bytes = sizeof(float) * first.sigma.size();
    EXPECT_EQ(0,
              std::memcmp(
                  first.inverse_virtual_depth.data(), second.inverse_virtual_depth.data(), bytes));
    EXPECT_EQ(0, std::memcmp(first.sigma.data(), second.sigma.data(), bytes));
    EXPECT_EQ(0, std::memcmp(first.image[0].data(), second.image[0].data(), bytes));
  }
}

// 1/v at 0.2 m, but for limits: 0.125 with the 16 mm lens.
TEST(Processor, LongLensesAreSearchedCloserToTheCameraThanShortOnes) {
  const auto searched_from = [](const PlenopticCamera& camera, const DepthOptions& options = {}) {
    const LensTable lenses(camera);
    return DepthEstimator(camera, lenses, options).options().min_inverse_virtual_depth;
  };
  PlenopticCamera camera = SmallCamera();
  EXPECT_EQ(searched_from(camera), 0.1);
  camera.focal_length = 50e-3;
  camera.main_lens_mla_distance = 48.8e-3;
  EXPECT_EQ(searched_from(camera), 0.05);
  camera.focal_length = 25e-3;
  camera.main_lens_mla_distance = 24.1e-3;
  EXPECT_NEAR(searched_from(camera),
              camera.sensor_mla_distance / (1 / (1 / 25e-3 - 1 / 0.2) - 24.1e-3),
              1e-9);
  camera.main_lens_mla_distance = 26e-3;  // nothing real at any v
  EXPECT_EQ(searched_from(camera), 0.1);
  DepthOptions told;
  told.min_inverse_virtual_depth = 0.2;
  EXPECT_EQ(searched_from(camera, told), 0.2);
  EXPECT_EQ(searched_from(SmallCamera(320, MicroLensMode::kKeplerian)), 0.1);
}

// Mean absolute difference of a focused image of chief rays from the texture on a plane at 1/v = w.
double ErrorOfChiefRays(const PlenopticCamera& camera, double w, const ImageF& image) {
  const Eigen::Vector2d c = camera.raw_principal_point;
  const double virtual_scale =
      (camera.main_lens_mla_distance + camera.sensor_mla_distance / w) / camera.focal_length;
  double sum = 0;
  for (int y = 30; y < 130; ++y) {
    for (int x = 30; x < 130; ++x) {
      const Eigen::Vector2d X = (RawFromFocused(camera, {x, y}) - c) * virtual_scale + c;
      sum += std::abs(image(x, y) / 0.99 - WavyTexture(X.x(), X.y()));
    }
  }
  return sum / 10000;
}

TEST(Processor, ImagesOfChiefRaysShowThePlaneAndItsDepthWhereThePinholeInTheMainLensDoes) {
  PlenopticCamera camera = SmallCamera();
  // Off the image: what is displaced along chief rays is so by many px.
  camera.raw_principal_point = {-180, 430};
  camera.focused_image = FocusedImage::kChiefRays;
  for (const double w : {0.2, 0.28, 0.36}) {
    LightFieldProcessor processor(camera, White(camera), {});
    const LightFieldFrame frame =
        processor.Process(Frame(RenderPlane(camera, w, WavyTexture, 1.5, true)));
    EXPECT_LT(ErrorOfChiefRays(camera, w, frame.image[0]), 6) << w;
    int measured = 0;
    double sum = 0;
    for (size_t i = 0; i < frame.sigma.size(); ++i) {
      if (frame.sigma.data()[i] == 0) continue;
      sum += frame.inverse_virtual_depth.data()[i] - w;
      ++measured;
    }
    EXPECT_GT(measured, 6000) << w;
    EXPECT_NEAR(sum / measured, 0, 0.001) << w;
  }
}

// The reason for them: depth is known to some per cent.
TEST(FocusedImage, OfChiefRaysIsNotDisplacedByDepthTakenWrongly) {
  constexpr double kTrue = 0.3, kTaken = 0.33;
  PlenopticCamera camera = SmallCamera();
  camera.raw_principal_point = {-180, 430};
  const auto error = [&](FocusedImage image) {
    camera.focused_image = image;
    const LensTable lenses(camera);
    RawPreparation preparation(lenses, White(camera), {});
    PreparedRaw prepared;
    preparation.Prepare(RenderPlane(camera, kTrue, WavyTexture, 0, true), &prepared);
    const int width = camera.focused_width(), height = camera.focused_height();
    ImageF right, wrong;
    RenderFocusedImage(camera,
                       lenses,
                       prepared.gray,
                       prepared.lens_colour,
                       ImageF(width, height, static_cast<float>(kTrue)),
                       &right);
    RenderFocusedImage(camera,
                       lenses,
                       prepared.gray,
                       prepared.lens_colour,
                       ImageF(width, height, static_cast<float>(kTaken)),
                       &wrong);
    double sum = 0;
    for (int y = 30; y < 130; ++y) {
      for (int x = 30; x < 130; ++x) sum += std::abs(right(x, y) - wrong(x, y));
    }
    return sum / 10000;
  };
  EXPECT_GT(error(FocusedImage::kVirtualPoints), 8);
  EXPECT_LT(error(FocusedImage::kChiefRays), 2);
}

TEST(Processor, FrameWithoutTextureHasAnImageAndNoDepth) {
  const PlenopticCamera camera = SmallCamera();
  LightFieldProcessor processor(camera, White(camera), LightFieldOptions{});
  const LightFieldFrame frame = processor.Process(Frame(RenderPlane(
      camera, 0.3, [](double, double) { return 130; }, 2, true)));
  const long measured = std::count_if(frame.sigma.data(),
                                      frame.sigma.data() + frame.sigma.size(),
                                      [](float sigma) { return sigma > 0; });
  EXPECT_LT(measured, 0.005 * static_cast<double>(frame.sigma.size()));
  EXPECT_NEAR(frame.image[0](80, 80), 130, 8);
}

TEST(Processor, SixteenBitsAndColourGiveWhatEightBitGrayGives) {
  const PlenopticCamera camera = SmallCamera();
  const cv::Mat gray = RenderPlane(camera, 0.3, WavyTexture);
  cv::Mat deep, colour;
  gray.convertTo(deep, CV_16U, 257);
  cv::merge(std::vector<cv::Mat>{gray, gray, gray}, colour);
  LightFieldProcessor processor(camera, cv::Mat(), LightFieldOptions{});
  const LightFieldFrame expected = processor.Process(Frame(gray));
  for (const cv::Mat& image : {deep, colour}) {
    const LightFieldFrame frame = processor.Process(Frame(image));
    EXPECT_NEAR(frame.image[0](80, 70), expected.image[0](80, 70), 0.01);
    EXPECT_NEAR(frame.inverse_virtual_depth(80, 70), expected.inverse_virtual_depth(80, 70), 1e-4);
  }
}

// Red is half as bright as green, blue a quarter, in a colour image and in a Bayer mosaic.
TEST(Processor, ColourIsFocusedWhereItIsAskedFor) {
  const PlenopticCamera camera = SmallCamera();
  const cv::Mat green = RenderPlane(camera, 0.3, WavyTexture, 0, true);
  cv::Mat colour, mosaic = green.clone();
  cv::merge(std::vector<cv::Mat>{green * 0.25, green, green * 0.5}, colour);
  for (int y = 0; y < mosaic.rows; ++y) {
    for (int x = 0; x < mosaic.cols; ++x) {  // GBRG
      const double gain = x % 2 == y % 2 ? 1 : y % 2 == 0 ? 0.25 : 0.5;
      mosaic.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(gain * mosaic.at<uint8_t>(y, x));
    }
  }
  LightFieldOptions options;
  EXPECT_TRUE(
      LightFieldProcessor(camera, cv::Mat(), options).Process(Frame(colour)).colour.empty());
  options.focus_colour = true;
  EXPECT_TRUE(LightFieldProcessor(camera, cv::Mat(), options).Process(Frame(green)).colour.empty());
  const LightFieldFrame of_colour =
      LightFieldProcessor(camera, White(camera), options).Process(Frame(colour));
  options.preparation.pixels = RawPixels::kBayerGbrg;
  const LightFieldFrame of_mosaic =
      LightFieldProcessor(camera, White(camera), options).Process(Frame(mosaic));
  for (const LightFieldFrame& frame : {of_colour, of_mosaic}) {
    ASSERT_EQ(frame.colour.size(), cv::Size(160, 160));
    const cv::Scalar mean = cv::mean(frame.colour(cv::Rect(40, 40, 80, 80)));
    EXPECT_NEAR(mean[0] / mean[1], 0.25, 0.01);
    EXPECT_NEAR(mean[2] / mean[1], 0.5, 0.01);
    EXPECT_NEAR(mean[1], 120, 8);
  }
}

// MiB of this process, VmRSS or VmHWM.
double MemoryMib(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(key + ":", 0) == 0) return std::stod(line.substr(key.size() + 1)) / 1024;
  }
  return NAN;
}

// In a process of its own: what tests before this one took would count.
[[noreturn]] void ProcessALargeFrame(double max_bytes_per_px) {
  constexpr int kSize = 4400;
  PlenopticCamera camera = SmallCamera(kSize);
  camera.micro_lens_grid->types = {{{0, 0}, 1, 3.2}, {{0, 1}, 2.6, 4.2}, {{0, -1}, 3.5, 100}};
  const cv::Mat raw(kSize, kSize, CV_8UC1, cv::Scalar(120)), white(raw.size(), CV_8UC1, 230);
  const double before = MemoryMib("VmRSS");
  {
    LightFieldProcessor processor(camera, white, {});
    for (int frame = 0; frame < 2; ++frame) processor.Process(Frame(raw));
  }
  const double bytes = (MemoryMib("VmHWM") - before) * 1024 * 1024;
  const double bytes_per_px = bytes / (1.0 * kSize * kSize);
  std::fprintf(stderr, "%.1f bytes a raw pixel\n", bytes_per_px);
  std::_Exit(bytes_per_px < max_bytes_per_px ? 0 : 1);
}

TEST(ProcessorDeathTest, AFrameOfALargeSensorTakesFewBytesAPixel) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take memory of their own";
#endif
  if (!std::filesystem::exists("/proc/self/status")) GTEST_SKIP() << "needs /proc";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(ProcessALargeFrame(30), ::testing::ExitedWithCode(0), "");
}

TEST(Processor, MeetsItsAccuracyOnHouseRaw) {
  const std::string folder = PRISM_SOURCE_DIR "/../shared/data/house_raw";
  if (!std::filesystem::exists(folder + "/raw.txt")) {
    GTEST_SKIP() << "needs ../shared/data/house_raw";
  }
  PlenopticCamera camera = ReadPlenopticCamera(folder + "/CameraModel.xml");
  camera.micro_lens_grid = ReadMicroLensGrid(folder + "/MLA_Calibration.xml");
  const RawSequence sequence(folder, camera);
  LightFieldProcessor processor(
      camera, ReadWhiteImage(sequence.WhiteImagePath(), camera), LightFieldOptions{});
  const LightFieldFrame frame = processor.Process(sequence.Read(8));
  DepthAccuracyEvaluator evaluator;
  evaluator.Add(frame.inverse_virtual_depth,
                frame.sigma,
                ReadInverseVirtualDepth(folder + "/virtual_depth_truth/000008.png", 1024, 1024));
  const DepthAccuracy ten = evaluator.Evaluate()[1];
  EXPECT_LE(ten.median_abs_error, 0.0025);
  EXPECT_LE(std::abs(ten.median_error), 0.0006);
  EXPECT_LE(ten.fraction_above_0_02, 0.015);
  EXPECT_GT(ten.normalized_sigma, 0.7);
  EXPECT_LT(ten.normalized_sigma, 1.4);
}

}  // namespace
}  // namespace prism
