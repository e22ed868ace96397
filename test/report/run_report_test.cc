// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/run_report.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "prism/report/base64.h"

namespace prism {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Base64Of(const std::string& text) {
  return Base64(reinterpret_cast<const unsigned char*>(text.data()), text.size());
}

TEST(Base64, EncodesTheTestVectorsOfRfc4648) {
  EXPECT_EQ(Base64Of(""), "");
  EXPECT_EQ(Base64Of("f"), "Zg==");
  EXPECT_EQ(Base64Of("fo"), "Zm8=");
  EXPECT_EQ(Base64Of("foo"), "Zm9v");
  EXPECT_EQ(Base64Of("foobar"), "Zm9vYmFy");
}

TEST(RunReport, ProblemsNameLostFramesAndSegments) {
  std::vector<ReportFrame> frames(6);
  for (ReportFrame& frame : frames) frame.is_tracked = true;
  EXPECT_TRUE(FindProblems(frames).empty());
  for (int i : {1, 3, 4}) {
    frames[i].is_tracked = false;
    frames[i].status = "lost";
  }
  frames[5].segment = 1;
  EXPECT_THAT(FindProblems(frames),
              ElementsAre("frame 1 not tracked (lost)",
                          "frames 3 to 4 not tracked (lost)",
                          "the trajectory has 2 segments"));
}

TEST(RunReport, ThumbnailIsHalvedUntilItFits) {
  const ImageF image(1300, 600, 100.0f);
  ReportKeyframe keyframe;
  EXPECT_EQ(ThumbnailFactor(1300, 512), 0.25);
  EXPECT_EQ(ThumbnailFactor(512, 512), 1);
  SetThumbnail(MakeThumbnail(image, cv::Mat(), 512), &keyframe);
  EXPECT_EQ(keyframe.width, 325);
  EXPECT_EQ(keyframe.height, 150);
  EXPECT_EQ(keyframe.jpeg.substr(0, 2), "\xff\xd8");
}

TEST(RunReport, SmallDepthIsTheMostCertainMeasurementOfEachBlock) {
  ImageF inverse_virtual_depth(1024, 512, 0), sigma(1024, 512, 0);
  const auto measure = [&](int x, int y, float w, float sigma_w) {
    inverse_virtual_depth(x, y) = w;
    sigma(x, y) = sigma_w;
  };
  measure(4, 0, 0.30F, 0.004F);
  measure(5, 3, 0.31F, 0.002F);
  measure(7, 1, 0.32F, 0.003F);
  const SmallDepth small = MakeSmallDepth(inverse_virtual_depth, sigma, 256);
  ASSERT_EQ(small.sigma.width(), 256);
  ASSERT_EQ(small.sigma.height(), 128);
  EXPECT_EQ(small.inverse_virtual_depth(1, 0), 0.31F);
  EXPECT_EQ(small.sigma(1, 0), 0.002F);
  EXPECT_EQ(small.sigma(0, 0), 0);
  EXPECT_EQ(small.inverse_virtual_depth(2, 0), 0);
}

TEST(RunReport, DepthMapsTellMeasuredFromNotMeasured) {
  SmallDepth depth{ImageF(100, 1, 0), ImageF(100, 1, 0)};
  ReportKeyframe keyframe;
  SetDepthMaps(depth, &keyframe);
  EXPECT_EQ(keyframe.inverse_virtual_depth.png, "") << "nothing was measured";
  for (int x = 1; x < 100; ++x) {
    depth.inverse_virtual_depth(x, 0) = 0.2F + 0.001F * static_cast<float>(x);
    depth.sigma(x, 0) = 0.003F;
  }
  SetDepthMaps(depth, &keyframe);
  const ReportMap& map = keyframe.inverse_virtual_depth;
  EXPECT_NEAR(map.low, 0.202, 1e-6);
  EXPECT_NEAR(map.high, 0.297, 0.0011);
  const std::vector<char> bytes(map.png.begin(), map.png.end());
  const cv::Mat levels = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  EXPECT_EQ(levels.at<uint8_t>(0, 0), 0);
  EXPECT_EQ(levels.at<uint8_t>(0, 1), 1);
  EXPECT_NEAR(levels.at<uint8_t>(0, 50), ReportMap::kLevels / 2.0, 1);
  EXPECT_EQ(levels.at<uint8_t>(0, 99), ReportMap::kLevels);
}

TEST(RunReport, ProblemsOfALongRunAreCounted) {
  std::vector<ReportFrame> frames(1000);
  for (size_t i = 0; i < frames.size(); i += 2) frames[i].is_tracked = true;
  const std::vector<std::string> problems = FindProblems(frames);
  EXPECT_EQ(problems.size(), 48U);
  EXPECT_EQ(problems.front(), "frame 1 not tracked ()");
  EXPECT_EQ(problems.back(), "453 more frames not tracked");
}

// As large as it gets: pictures of noise, which JPEG and PNG do not make smaller.
ReportKeyframe NoisyKeyframe() {
  std::mt19937 generator(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  ReportKeyframe keyframe;
  cv::Mat noise(512, 512, CV_8UC3);
  cv::theRNG().state = 5;
  cv::randu(noise, 0, 256);
  SetThumbnail(noise, &keyframe);
  SmallDepth depth{ImageF(256, 256, 0), ImageF(256, 256, 0)};
  for (size_t i = 0; i < depth.sigma.size(); ++i) {
    depth.inverse_virtual_depth.data()[i] = 0.1F + 0.4F * uniform(generator);
    depth.sigma.data()[i] = 0.001F + 0.1F * uniform(generator);
  }
  SetDepthMaps(depth, &keyframe);
  keyframe.points.resize(500, {1, 2, 3, 4});
  return keyframe;
}

RunReport LongRun(int frames) {
  RunReport report;
  const ReportKeyframe picture = NoisyKeyframe();
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-300, 300);
  for (int i = 0; i < frames; ++i) {
    ReportFrame frame;
    frame.time_ns = 1600000000000000000 + i * int64_t{33333333};
    frame.status = "tracked";
    frame.is_tracked = i % 10 != 5;
    frame.is_keyframe = i % 3 == 0 && frame.is_tracked;
    frame.residual_rms = uniform(generator);
    frame.points = 1500;
    frame.brightness_a = uniform(generator);
    frame.brightness_b = uniform(generator);
    frame.scale_sigma = 0.0123456;
    for (const char* stage : {"read image",
                              "vignetting",
                              "depth",
                              "fuse depth",
                              "focused image",
                              "track",
                              "make reference",
                              "update candidates",
                              "realign frames"}) {
      frame.stage_ms[stage] = std::abs(uniform(generator));
    }
    const SE3 pose(Eigen::Quaterniond::Identity(),
                   Eigen::Vector3d(uniform(generator), uniform(generator), uniform(generator)));
    if (frame.is_tracked) report.trajectory.push_back({frame.time_ns, pose});
    report.groundtruth.push_back({frame.time_ns, pose});
    if (frame.is_keyframe) {
      report.keyframes.push_back(picture);
      report.keyframes.back().time_ns = frame.time_ns;
      report.keyframes.back().world_from_cam = pose;
      if (report.keyframes.size() > 208) report.keyframes.back().DropPictures();
    }
    report.frames.push_back(frame);
  }
  report.pieces.assign(report.trajectory.size(), 0);
  report.cloud.resize(static_cast<size_t>(100 * frames));
  report.dense.resize(static_cast<size_t>(100 * frames));
  report.metrics = EvaluateTrajectory(report.groundtruth, report.trajectory);
  return report;
}

TEST(RunReport, PageStaysBelow20MbHoweverLongTheRun) {
  for (const int frames : {5999, 10000, 30000}) {
    EXPECT_LT(FormatReport(LongRun(frames)).size(), 20e6) << frames;
  }
}

TEST(RunReport, WhatALongRunLeavesOutIsSaidAndTheRestFitsTogether) {
  const nlohmann::json json = ReportToJson(LongRun(10000));
  EXPECT_EQ(json["frame_step"], 2);
  EXPECT_EQ(json["frame_count"], 10000);
  EXPECT_EQ(json["tracked_count"], 9000);
  ASSERT_EQ(json["frames"].size(), 5000U);
  size_t tracked = 0;
  for (const auto& frame : json["frames"]) tracked += frame["tracked"].get<bool>();
  EXPECT_EQ(json["trajectory"].size(), 3 * tracked);
  EXPECT_EQ(json["pieces"].size(), tracked);
  EXPECT_EQ(json["stages"]["track"]["count"], 10000);
  size_t pictures = 0;
  for (const auto& keyframe : json["keyframes"]) pictures += keyframe.contains("jpeg");
  EXPECT_GT(pictures, 10U);
  EXPECT_LT(pictures, 208U);
  const auto left_out = json["left_out"].get<std::vector<std::string>>();
  EXPECT_THAT(
      left_out,
      ElementsAre("one in 2 of the 10000 frames is shown; problems and stage times are those "
                  "of all",
                  std::to_string(pictures) + " of the 3001 keyframes have their picture here",
                  HasSubstr("keyframes without picture are not shown"),
                  "one in 17 of the 1000000 points is shown",
                  "one in 9 of the 1000000 points of fused depth is shown"));
}

TEST(RunReport, PageIsSelfContainedAndItsDataCannotEndTheScript) {
  RunReport report;
  report.title = "</script><b><!--<script>";
  report.trajectory = {{0, SE3()}};
  const std::string page = FormatReport(report);
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cb>\\u003c!--\\u003cscript>"));
  for (const char* outside : {"src=\"http", "href=\"http", "sourceMappingURL", "%REPORT_DATA%"}) {
    EXPECT_THAT(page.find(outside), std::string::npos) << outside;
  }
}

}  // namespace
}  // namespace prism
