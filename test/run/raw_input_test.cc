// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/raw_input.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "prism/base/error.h"
#include "test/run/raw_folder.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class RawInputTest : public testing::Test {
 protected:
  RawInputTest() : folder_(FreshFolder("raw")), camera_(SmallCamera()) {
    WriteRawFolder(folder_, 1);
  }
  RawInput Open() const {
    return OpenRawInput({folder_, folder_ + "/camera.yaml", "", "", "auto"});
  }
  std::string MessageOf(const RawInputOptions& options) const {
    try {
      OpenRawInput(options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::string folder_;
  PlenopticCamera camera_;
};

TEST_F(RawInputTest, RefinesTheGridOnTheWhiteImage) {
  PlenopticCamera moved = camera_;
  moved.micro_lens_grid->offset_px += Eigen::Vector2d(0.6, -0.4);
  WriteNativeCamera(folder_ + "/camera.yaml", moved);
  const RawInput input = Open();
  const Eigen::Vector2d found = input.camera.micro_lens_grid->offset_px;
  EXPECT_LT((found - camera_.micro_lens_grid->offset_px).norm(), 0.05) << found.transpose();
  EXPECT_THAT(input.grid_report, HasSubstr("refined on the white image"));
  EXPECT_FALSE(input.white.empty());
}

TEST_F(RawInputTest, AGridThatWouldHaveToMoveFarIsAnotherOne) {
  PlenopticCamera moved = camera_;
  moved.micro_lens_grid->offset_px.x() += 0.42 * moved.micro_lens_grid->diameter_px;
  WriteNativeCamera(folder_ + "/camera.yaml", moved);
  EXPECT_THAT(MessageOf({folder_, folder_ + "/camera.yaml", "", "", "auto"}),
              AllOf(HasSubstr("camera.yaml: found micro images up to"), HasSubstr("this camera")));
}

TEST_F(RawInputTest, RefinesTheGridOnTheFramesWhereThereIsNoWhiteImage) {
  std::filesystem::remove(folder_ + "/white.png");
  const RawInput input = Open();
  EXPECT_THAT(input.grid_report, HasSubstr("refined on the raw frames"));
}

TEST_F(RawInputTest, FindsTheVignettingOnTheFramesWhereThereIsNoWhiteImage) {
  std::filesystem::remove(folder_ + "/white.png");
  const RawInput input = Open();
  EXPECT_THAT(input.grid_report, HasSubstr("no white image: vignetting found on"));
  EXPECT_FALSE(input.white.empty());
  const RawInput as_it_is =
      OpenRawInput({folder_, folder_ + "/camera.yaml", "", kNoWhiteImage, "auto"});
  EXPECT_TRUE(as_it_is.white.empty());
}

TEST_F(RawInputTest, AGridFileReplacesTheCamerasGrid) {
  PlenopticCamera bare = camera_;
  bare.micro_lens_grid.reset();
  WriteNativeCamera(folder_ + "/bare.yaml", bare);
  WriteRaytrixGrid(folder_ + "/grid.xml", *camera_.micro_lens_grid);
  EXPECT_THAT(
      MessageOf({folder_, folder_ + "/bare.yaml", "", "", "auto"}),
      AllOf(HasSubstr("bare.yaml: found no micro-lens grid"), HasSubstr("micro_lens_grid")));
  EXPECT_EQ(MessageOf({folder_, folder_ + "/bare.yaml", folder_ + "/grid.xml", "", "auto"}),
            "no error");
}

TEST_F(RawInputTest, AnUnknownColourIsABadOption) {
  EXPECT_THROW(OpenRawInput({folder_, folder_ + "/camera.yaml", "", "", "sepia"}), OptionError);
  EXPECT_THAT(MessageOf({folder_, folder_ + "/camera.yaml", "", "", "sepia"}),
              HasSubstr("colour: found 'sepia', expected auto, gray"));
}

TEST_F(RawInputTest, UpsideDownMicroImagesAreReadInTheOtherMode) {
  const PlenopticCamera keplerian = SmallCamera(320, MicroLensMode::kKeplerian);
  WriteRawFolder(folder_, 1, keplerian);
  EXPECT_EQ(Open().camera.mode, MicroLensMode::kKeplerian);
  EXPECT_EQ(Open().grid_report.find("upside down"), std::string::npos);
  PlenopticCamera mistaken = keplerian;
  mistaken.mode = MicroLensMode::kGalilean;
  WriteNativeCamera(folder_ + "/camera.yaml", mistaken);
  const RawInput input = Open();
  EXPECT_EQ(input.camera.mode, MicroLensMode::kKeplerian);
  EXPECT_THAT(input.grid_report, HasSubstr("upside down for a galilean camera"));
}

TEST_F(RawInputTest, AMosaicIsNotTakenForGray) {
  cv::Mat raw = cv::imread(folder_ + "/0.png", cv::IMREAD_UNCHANGED);
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      const double gain = x % 2 != y % 2 ? 1 : x % 2 == 0 ? 0.8 : 0.5;  // RGGB
      raw.at<uint8_t>(y, x) = static_cast<uint8_t>(gain * raw.at<uint8_t>(y, x));
    }
  }
  cv::imwrite(folder_ + "/0.png", raw);
  const std::string camera = folder_ + "/camera.yaml";
  for (const char* wrong : {"auto", "bayer_grbg"}) {
    EXPECT_THAT(MessageOf({folder_, camera, "", "", wrong}),
                AllOf(HasSubstr("0.png: found a colour mosaic"), HasSubstr("bayer_rggb")))
        << wrong;
  }
  EXPECT_EQ(MessageOf({folder_, camera, "", "", "bayer_rggb"}), "no error");
  EXPECT_EQ(MessageOf({folder_, camera, "", "", "gray"}), "no error");
}

// Vignetting-corrected frames show no rims to refine the grid on; lenses agree with the right sign.
TEST_F(RawInputTest, TheSignOfTheRotationIsDecidedByWhatLensesAgreeOn) {
  camera_ = SmallCamera(640);
  camera_.micro_lens_grid->rotation = 0.004;
  std::filesystem::remove(folder_ + "/white.png");
  cv::imwrite(folder_ + "/0.png", RenderPlane(camera_, 0.3, WavyTexture, 1));
  for (const double filed : {0.004, -0.004}) {
    PlenopticCamera camera = camera_;
    camera.micro_lens_grid->rotation = filed;
    WriteNativeCamera(folder_ + "/camera.yaml", camera);
    const RawInput input = Open();
    EXPECT_NEAR(input.camera.micro_lens_grid->rotation, 0.004, 5e-4) << input.grid_report;
  }
}

// Frames in which the lenses of type 1 are sharp and those of types 0 and 2 are not, opened with a
// file that has them right and one that has types 1 and 2 exchanged.
TEST_F(RawInputTest, TheOrderOfLensTypesIsDecidedBySharpness) {
  MicroLensGrid& grid = *camera_.micro_lens_grid;
  grid.types = {{{0, 0}, 2, 2.2}, {{1, 0}, 3, 3.6}, {{0.5, 0.8660254}, 6, 8}};
  MicroLensGrid exchanged = grid;
  std::swap(exchanged.types[1].offset, exchanged.types[2].offset);
  const cv::Mat sharp = RenderPlane(camera_, 0.305, WavyTexture, 1);
  cv::Mat raw;
  cv::GaussianBlur(sharp, raw, {}, 1.6);
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      const LensIndex lens = grid.NearestLens({x, y}, raw.cols, raw.rows);
      if (grid.TypeOf(lens) == 1) raw.at<uint8_t>(y, x) = sharp.at<uint8_t>(y, x);
    }
  }
  cv::imwrite(folder_ + "/0.png", raw);
  std::filesystem::remove(folder_ + "/white.png");
  for (const MicroLensGrid& filed : {grid, exchanged}) {
    camera_.micro_lens_grid = filed;
    WriteNativeCamera(folder_ + "/camera.yaml", camera_);
    const RawInput input = Open();
    EXPECT_LT((input.camera.micro_lens_grid->types[1].offset - Eigen::Vector2d(1, 0)).norm(), 1e-9)
        << input.grid_report;
  }
}

}  // namespace
}  // namespace prism
