// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "test/io/rgbd_folder.h"
#include "test/tools/run_program.h"

namespace prism {
namespace {

using testing::HasSubstr;

int CountLines(const std::string& path) {
  std::ifstream file(path);
  int count = 0;
  for (std::string line; std::getline(file, line);) ++count;
  return count;
}

TEST(PrismDisturb, WritesASequenceWithItsFramesLeftOutAndDarkened) {
  const std::string in = FreshFolder("in"), dropped = FreshFolder("dropped"),
                    dark = FreshFolder("dark");
  RgbdFolderOptions options;
  options.num_frames = 6;
  WriteRgbdFolder(in, options);
  ProgramResult result = RunProgram("prism_disturb --sequence=" + in + " --output_dir=" + dropped +
                                    " --drop --first=2 --count=3");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("3 of 6 frames"));
  EXPECT_EQ(CountLines(dropped + "/associations.txt"), 3);

  result = RunProgram("prism_disturb --sequence=" + in + " --output_dir=" + dark +
                      " --exposure=0.5 --first=3");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  std::ifstream list(dark + "/associations.txt");
  std::string time, image, depth_time, depth;
  std::vector<double> means;
  while (list >> time >> image >> depth_time >> depth) {
    means.push_back(cv::mean(cv::imread(dark + "/" + image, cv::IMREAD_GRAYSCALE))[0]);
  }
  ASSERT_EQ(means.size(), 6u);
  EXPECT_NEAR(means[3] / means[2], 0.5, 0.1);
  // What it wrote is a sequence to itself.
  EXPECT_EQ(RunProgram("prism_disturb --sequence=" + dark + " --output_dir=" + FreshFolder("again"))
                .exit_status,
            0);
}

TEST(PrismDisturb, AKidnapGoesOnElsewhereAfterBlackFramesWithTimesThatRise) {
  const std::string in = FreshFolder("in"), out = FreshFolder("out");
  RgbdFolderOptions options;
  options.num_frames = 8;
  WriteRgbdFolder(in, options);
  const ProgramResult result =
      RunProgram("prism_disturb --sequence=" + in + " --output_dir=" + out +
                 " --first=5 --count=2 --kidnap_to=1");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  std::ifstream list(out + "/associations.txt");
  std::string image, depth_time, depth;
  std::vector<double> times, means;
  for (double time; list >> time >> image >> depth_time >> depth;) {
    times.push_back(time);
    means.push_back(cv::mean(cv::imread(out + "/" + image, cv::IMREAD_GRAYSCALE))[0]);
  }
  ASSERT_EQ(times.size(), 5u + 2 + 7);
  EXPECT_LT(means[5], 5);
  EXPECT_EQ(means[7], means[1]);  // the view of frame 1
  for (size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i], times[i - 1]);
}

TEST(PrismDisturb, BadInputIsToldAndNothingIsWritten) {
  const std::string in = FreshFolder("in"), out = FreshFolder("out") + "/new";
  WriteRgbdFolder(in);
  for (const char* flags :
       {" --exposure=0", " --gross_depths=2", " --first=-1", " --kidnap_to=1000"}) {
    const ProgramResult result =
        RunProgram("prism_disturb --sequence=" + in + " --output_dir=" + out + flags);
    EXPECT_EQ(result.exit_status, 2) << flags;
    EXPECT_THAT(result.output, HasSubstr("expected")) << flags;
  }
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_EQ(RunProgram("prism_disturb --sequence=" + in + " --output_dir=" + in).exit_status, 2);
  EXPECT_EQ(
      RunProgram("prism_disturb --sequence=" + in + "/nowhere --output_dir=" + out).exit_status, 2);
}

}  // namespace
}  // namespace prism
