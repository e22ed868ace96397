// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// A folder and nothing else: what Sequence finds in it.
#include "prism/run/folder_contents.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/camera/projection.h"
#include "prism/io/rgbd_sequence.h"
#include "test/run/raw_folder.h"

namespace prism {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string ErrorOf(const SequenceOptions& options) {
  try {
    Sequence sequence(options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FolderContents, RawFramesWithoutAListRunWithTheCalibrationBesideThem) {
  SequenceOptions options;
  options.sequence = FreshFolder("my raw frames");
  const PlenopticCamera camera = SmallCamera();
  WriteRawFolder(options.sequence, 2, camera);
  std::filesystem::remove(options.sequence + "/raw.txt");
  std::filesystem::remove(options.sequence + "/camera.yaml");
  EXPECT_THAT(ErrorOf(options), HasSubstr("found neither camera.yaml nor CameraModel.xml"));
  WriteLifcalCamera(options.sequence + "/CameraModel.xml", camera);
  EXPECT_THAT(ErrorOf(options), HasSubstr("found no micro-lens grid"));
  WriteRaytrixGrid(options.sequence + "/mla_calibration.xml", *camera.micro_lens_grid);

  options.rate_hz = 5;
  Sequence sequence(options);
  EXPECT_EQ(sequence.format(), "raw");
  ASSERT_EQ(sequence.size(), 2);
  sequence.Next();
  EXPECT_EQ(sequence.Next()->time_ns, 200000000);
  EXPECT_THAT(sequence.input_report(), Contains("camera: CameraModel.xml of the folder"));
  EXPECT_THAT(sequence.input_report(),
              Contains("micro-lens grid: mla_calibration.xml of the folder"));
  EXPECT_THAT(sequence.input_report(), Contains(HasSubstr("2 images of the folder")));
  EXPECT_THAT(sequence.input_report(), Contains(HasSubstr("refined on the white image")));
  EXPECT_THAT(sequence.camera_path(), HasSubstr("CameraModel.xml"));
}

TEST(FolderContents, TumRunsWithAPinholeGivenAndNoCalibration) {
  SequenceOptions options;
  options.sequence = FreshFolder("tum");
  WriteRgbdFolder(options.sequence);
  Sequence with_file(options);
  std::filesystem::remove(options.sequence + "/calibration.txt");
  EXPECT_THAT(ErrorOf(options), HasSubstr("--pinhole=fx,fy,cx,cy"));
  options.pinhole = "262.5,262.5,160,120";
  Sequence given(options);
  EXPECT_THAT(given.input_report(), Contains(HasSubstr("Raytrix R5")));
  const auto a = with_file.Next(), b = given.Next();
  for (int i = 0; i < 320; ++i) ASSERT_EQ(a->image[0](i, 77), b->image[0](i, 77));
  options.pinhole = "262.5,262.5";
  EXPECT_THAT(ErrorOf(options), HasSubstr("pinhole: found '262.5,262.5'"));
  options.pinhole = "262.5,262.5,160,120";
  options.depth_factor = 0;
  EXPECT_THAT(ErrorOf(options), HasSubstr("depth_factor: found"));
}

// Depth is that of the pixel in the middle of the image, where all these cameras agree.
double DepthInTheMiddle(SequenceOptions options) {
  options.rgbd.inverse_depth_sigma = 0;
  Sequence sequence(options);
  const LightFieldFrame frame = *sequence.Next();
  const PlenopticProjection camera(sequence.camera());
  return 1 / InverseDepth(camera, frame.inverse_virtual_depth(160, 120));
}

TEST(FolderContents, DepthFactorIsThatOfTheImages) {
  SequenceOptions options;
  options.sequence = FreshFolder("depth");
  WriteRgbdFolder(options.sequence);
  const double depth = DepthInTheMiddle(options);
  EXPECT_NEAR(depth, 2, 0.05);
  options.depth_factor = 2500;
  EXPECT_NEAR(DepthInTheMiddle(options), 2 * depth, 0.02);
}

TEST(FolderContents, PixelsThatAreNotSquareAndDistortionAreTakenOut) {
  SequenceOptions options;
  options.sequence = FreshFolder("distorted");
  WriteRgbdFolder(options.sequence);
  Sequence square(options);
  // As if the picture were stretched: pixel (x, y) of the square one shows what stands at
  // fy / f (y - cy) + cy.
  options.pinhole = "262.5,289.0,160,120";
  Sequence stretched(options);
  EXPECT_DOUBLE_EQ(PlenopticProjection(stretched.camera()).FocalLengthPx() /
                       PlenopticProjection(square.camera()).FocalLengthPx(),
                   275.75 / 262.5);
  options.pinhole = "262.5,262.5,160,120,0.1,0,0,0";
  Sequence distorted(options);
  const LightFieldFrame a = *square.Next(), b = *distorted.Next(), c = *stretched.Next();
  EXPECT_NEAR(a.image[0](160, 120), b.image[0](160, 120), 3);
  EXPECT_NEAR(a.image[0](160, 120), c.image[0](160, 120), 3);
  double difference = 0;
  for (int x = 20; x < 300; ++x) difference += std::abs(a.image[0](x, 30) - b.image[0](x, 30));
  EXPECT_GT(difference / 280, 3) << "the border moves by pixels";
}

TEST(Pinhole, KnowsTheCamerasOfTheTumBenchmark) {
  EXPECT_EQ(ParsePinhole("freiburg1").size(), 9u);
  EXPECT_THAT(ParsePinhole("525,526,319.5,239.5"), testing::ElementsAre(525, 526, 319.5, 239.5));
  EXPECT_THROW(ParsePinhole("freiburg9"), OptionError);
  EXPECT_THROW(ParsePinhole("1,2,x,4"), OptionError);
}

}  // namespace
}  // namespace prism
