// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/micro_lens_estimation.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "test/run/raw_folder.h"

namespace prism {
namespace {

using testing::HasSubstr;

// Frames and white image of `camera`; its file says nothing of the micro lenses.
std::string FolderOf(const PlenopticCamera& camera) {
  const std::string folder = FreshFolder("micro_lenses");
  WriteRawFolder(folder, 2, camera);
  PlenopticCamera bare = camera;
  bare.mode = MicroLensMode::kGalilean;
  bare.micro_lens_grid.reset();
  WriteNativeCamera(folder + "/camera.yaml", bare);
  return folder;
}

class MicroLensesOf : public testing::TestWithParam<PlenopticCamera> {};

INSTANTIATE_TEST_SUITE_P(Cameras,
                         MicroLensesOf,
                         testing::Values(SmallCamera(),
                                         SmallCamera(320, MicroLensMode::kKeplerian),
                                         SquareCamera()),
                         CameraName);

TEST_P(MicroLensesOf, AreFoundFromTheFramesAlone) {
  const std::string folder = FolderOf(GetParam());
  for (const bool has_white : {true, false}) {
    if (!has_white) std::filesystem::remove(folder + "/white.png");
    const MicroLensEstimate estimate =
        EstimateMicroLenses({folder, folder + "/camera.yaml", "", "", "auto"});
    const PlenopticCamera& camera = estimate.camera;
    EXPECT_EQ(camera.mode, GetParam().mode) << estimate.report;
    ASSERT_TRUE(camera.micro_lens_grid);
    EXPECT_NEAR(camera.micro_lens_grid->diameter_px, 23.2023, 0.01);
    EXPECT_EQ(camera.micro_lens_grid->types.size(), 1u) << estimate.report;
    const Eigen::Vector2d center = GetParam().micro_lens_grid->MicroImageCenter({0, 0}, 320, 320);
    const Eigen::Vector2d found = camera.micro_lens_grid->MicroImageCenter(
        camera.micro_lens_grid->NearestLens(center, 320, 320), 320, 320);
    EXPECT_LT((found - center).norm(), 0.3) << estimate.report;
  }
}

TEST(MicroLensEstimation, WithoutAWhiteImageOrFramesIsAnError) {
  const std::string folder = FolderOf(SmallCamera());
  try {
    EstimateMicroLenses({"", folder + "/camera.yaml", "", "", "auto"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("neither a white image nor raw frames"));
  }
}

}  // namespace
}  // namespace prism
