// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// From a rendered scene to a trajectory in metres: prism_simulate, prism_lightfield and prism_vo
// one after the other on a small raw sequence. Bounds are about twice the worst of six seeds.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/image_file.h"
#include "prism/io/raw_sequence.h"
#include "prism/lightfield/grid_estimation.h"
#include "test/tools/run_bytes.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 24;
const std::string kHere = std::string(PRISM_SOURCE_DIR) + "/test/end_to_end/";

nlohmann::json ReadJson(const std::string& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

class RenderedSequence : public testing::Test {
 protected:
  // The raw sequence, and what prism_lightfield makes of it.
  static void SetUpTestSuite() {
    folder_ = testing::TempDir() + "rendered_sequence_" + std::to_string(getpid());
    fs::create_directories(folder_);
    simulate_ = RunProgram(
        "prism_simulate --trajectory=handheld --seed=15 --truth_every=1 --scene=" + kHere +
        "desk.yaml --camera=" + kHere + "camera.yaml --frames=" + std::to_string(kFrames) +
        " --output_dir=" + Raw());
    lightfield_ =
        RunProgram("prism_lightfield --raw=" + Raw() + " --truth=" + Raw() +
                   "/virtual_depth_truth --camera=" + Camera() + " --output_dir=" + Focused());
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  void SetUp() override {
    ASSERT_EQ(simulate_.exit_status, 0) << simulate_.output;
    ASSERT_EQ(lightfield_.exit_status, 0) << lightfield_.output;
  }

  static std::string Raw() { return folder_ + "/raw_sequence"; }
  static std::string Focused() { return folder_ + "/focused_sequence"; }
  static std::string Camera() { return Raw() + "/camera.yaml"; }

  // Runs prism_vo and holds its errors against bounds.
  static void ExpectAccurate(const std::string& sequence, double ate_m, double scale_percent) {
    const std::string output = folder_ + "/vo";
    const ProgramResult result =
        RunProgram("prism_vo --threads=1 --sequence=" + sequence + " --camera=" + Camera() +
                   " --groundtruth=" + Raw() + "/groundtruth.txt --output_dir=" + output);
    ASSERT_EQ(result.exit_status, 0) << result.output;
    const nlohmann::json metrics = ReadJson(output + "/metrics.json");
    EXPECT_EQ(metrics["matched_count"], kFrames);
    EXPECT_NEAR(metrics["path_length_m"].get<double>(), 0.168, 0.002);
    EXPECT_LT(metrics["ate_rmse_m"].get<double>(), ate_m);
    EXPECT_LT(metrics["scale_error_percent"].get<double>(), scale_percent);
    fs::remove_all(output);
  }

  static std::string folder_;
  static ProgramResult simulate_;
  static ProgramResult lightfield_;
};

std::string RenderedSequence::folder_;
ProgramResult RenderedSequence::simulate_;
ProgramResult RenderedSequence::lightfield_;

TEST_F(RenderedSequence, TheGridIsFoundInTheWhiteImageFromNothing) {
  const PlenopticCamera camera = ReadPlenopticCamera(Camera());
  const auto fit = EstimateGrid(MeanImage({ReadWhiteImage(Raw() + "/white.png", camera)}));
  ASSERT_TRUE(fit);
  const int size = camera.raw_width;
  for (double y = 30; y < size - 30; y += 23) {
    for (double x = 30; x < size - 30; x += 23) {
      const MicroLensGrid& truth = *camera.micro_lens_grid;
      const Eigen::Vector2d center =
          truth.MicroImageCenter(truth.NearestLens({x, y}, size, size), size, size);
      const Eigen::Vector2d found =
          fit->grid.MicroImageCenter(fit->grid.NearestLens(center, size, size), size, size);
      EXPECT_LT((found - center).norm(), 0.03) << center.transpose();
    }
  }
}

TEST_F(RenderedSequence, TheLightFieldsDepthIsTheTrueOne) {
  const nlohmann::json result = ReadJson(Focused() + "/lightfield.json");
  const nlohmann::json& accuracy = result["accuracy"];
  ASSERT_EQ(accuracy.size(), 4u);
  EXPECT_EQ(accuracy[1]["percent"], 10);
  EXPECT_LT(accuracy[1]["median_abs_error"].get<double>(), 0.007);
  EXPECT_LT(std::abs(accuracy[1]["median_error"].get<double>()), 0.0013);
  EXPECT_LT(accuracy[1]["fraction_above_0_02"].get<double>(), 0.035);
}

TEST_F(RenderedSequence, OdometryWithTrueDepthIsRightToMillimetres) {
  const std::string sequence = folder_ + "/true_depth";
  fs::create_directories(sequence);
  fs::create_directory_symlink(Focused() + "/focused", sequence + "/focused");
  fs::create_directory_symlink(Raw() + "/virtual_depth_truth", sequence + "/depth");
  std::ofstream list(sequence + "/focused.txt");
  const RawSequence raw(Raw(), ReadPlenopticCamera(Camera()));
  for (int i = 0; i < raw.size(); ++i) {
    const std::string png = fs::path(raw.path(i)).filename();
    list << FormatTime(raw.time_ns(i)) << " focused/" << png << " depth/" << png << "\n";
  }
  list.close();
  ExpectAccurate(sequence, 0.0018, 3.5);
}

TEST_F(RenderedSequence, OdometryOnRawFramesIsMetric) { ExpectAccurate(Raw(), 0.0035, 5); }

TEST_F(RenderedSequence, RawFramesGiveTheSameBytesWithAnyNumberOfThreads) {
  const auto bytes_of = [](const std::string& name, const std::string& threads) {
    const ProgramResult result =
        RunProgram("prism_vo --max_frames=12 --sequence=" + Raw() + " --camera=" + Camera() +
                   " --threads=" + threads + " --output_dir=" + folder_ + "/" + name);
    EXPECT_EQ(result.exit_status, 0) << result.output;
    return BytesOfRun(folder_ + "/" + name);
  };
  const auto bytes = bytes_of("one", "1");
  EXPECT_EQ(bytes, bytes_of("two", "2"));
  EXPECT_EQ(bytes, bytes_of("two_again", "2"));
}

TEST_F(RenderedSequence, OdometryOnTheFocusedLayoutIsMetric) {
  ExpectAccurate(Focused(), 0.0035, 5);
}

}  // namespace
}  // namespace prism
