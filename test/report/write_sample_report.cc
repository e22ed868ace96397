// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// write_sample_report PATH [FRAMES]: a report as a run of 228 frames, or so many, would leave it,
// made up, for the test in a browser. write_sample_report --live PORT: the same run as it goes on,
// in a second.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "prism/report/live_view.h"
#include "prism/report/run_report.h"

namespace prism {
namespace {

constexpr int kFrames = 228;
constexpr size_t kMostPictures = 200;  // as prism_vo keeps them
constexpr int kKeyframeStep = 5;
constexpr int kWithoutImage = 10;  // this frame's keyframe

SE3 PoseAt(int i, double scale) {
  const double t = i / 30.0;
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.1 * t, Eigen::Vector3d::UnitY()));
  return SE3(rotation, scale * Eigen::Vector3d(std::sin(t), 0.2 * std::cos(2 * t), 0.3 * t));
}

ReportKeyframe KeyframeAt(int i, std::mt19937* generator) {
  ReportKeyframe keyframe;
  keyframe.time_ns = i * int64_t{33333333};
  keyframe.world_from_cam = PoseAt(i, 1);
  // As noisy as real images, which is what makes JPEG files large.
  ImageF image(1024, 1024);
  std::normal_distribution<float> noise(0, 20);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image(x, y) = 128 +
                    60 * std::sin(0.05f * static_cast<float>(x + 3 * i)) *
                        std::cos(0.03f * static_cast<float>(y)) +
                    noise(*generator);
    }
  }
  SetThumbnail(MakeThumbnail(image, cv::Mat(), 512), &keyframe);
  ImageF inverse_virtual_depth(1024, 1024, 0), sigma(1024, 1024, 0);
  for (int y = 0; y < 1024; y += 2) {
    for (int x = y / 2; x < 1024; x += 3) {  // some of the left lower half is not measured
      inverse_virtual_depth(x, y) = 0.3F + 0.0001F * static_cast<float>(x);
      sigma(x, y) =
          0.002F + 0.000004F * static_cast<float>(y) + 1e-5F * std::abs(noise(*generator));
    }
  }
  SetDepthMaps(MakeSmallDepth(inverse_virtual_depth, sigma, 256), &keyframe);
  std::uniform_real_distribution<float> pixel(0, 511);
  std::uniform_real_distribution<float> depth_m(0.8f, 4);
  for (int k = 0; k < 400; ++k) {
    const float residual = k == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.02F * k;
    keyframe.points.push_back(
        {pixel(*generator), pixel(*generator), depth_m(*generator), residual});
  }
  return keyframe;
}

RunReport SampleReport(int frames) {
  std::mt19937 generator(7);
  RunReport report;
  report.title = "sample </script> & <run>";
  report.git_hash = "0123456789ab";
  report.wall_seconds = 10;
  report.processor_seconds = 18;
  report.options = {{"sequence", "sample"}, {"threads", "2"}};
  report.camera = {{"focal length", "16.7 mm"}};
  report.scale_sigma = 0.0123;
  report.view_x = 0.35;
  report.view_y = 0.35;
  for (int i = 0; i < frames; ++i) {
    const int64_t time_ns = i * int64_t{33333333};
    report.groundtruth.push_back({time_ns, PoseAt(i, 1)});
    ReportFrame frame;
    frame.time_ns = time_ns;
    frame.is_tracked = i < 100 || i >= 104;
    frame.status = frame.is_tracked ? "tracked" : "no texture";
    frame.is_keyframe = frame.is_tracked && i % kKeyframeStep == 0;
    frame.segment = i < 100 ? 0 : 1;
    frame.residual_rms = 5 + std::sin(0.1 * i);
    frame.points = 1500 + i;
    frame.brightness_a = 0.01 * std::sin(0.05 * i);
    // More stages than there are colours, some of which begin late.
    for (const char* stage : {"read image", "preparation", "depth", "focused image", "track"}) {
      frame.stage_ms[stage] = 12 + std::sin(0.1 * i);
    }
    if (frame.is_keyframe) frame.stage_ms["optimise"] = 60;
    if (frame.is_keyframe) frame.scale_sigma = 0.012;
    if (i >= 50) frame.stage_ms["realign"] = 2;
    if (frame.is_tracked) report.trajectory.push_back({time_ns, PoseAt(i, 0.97)});
    if (frame.is_keyframe && report.keyframes.size() < kMostPictures) {
      report.keyframes.push_back(KeyframeAt(i, &generator));
    } else if (frame.is_keyframe) {
      report.keyframes.push_back({});
      report.keyframes.back().time_ns = time_ns;
      report.keyframes.back().world_from_cam = PoseAt(i, 1);
    }
    if (i == kWithoutImage) report.keyframes.back().DropPictures();
    report.frames.push_back(frame);
  }
  std::uniform_real_distribution<float> coordinate(-2, 2);
  for (int k = 0; k < 100000; ++k) {
    report.cloud.push_back(
        {{coordinate(generator), coordinate(generator), 2 + coordinate(generator)},
         {static_cast<uint8_t>(k % 256), static_cast<uint8_t>(k % 256), 128}});
    report.dense.push_back({{coordinate(generator), 1, 2 + coordinate(generator)},
                            {static_cast<uint8_t>(k % 256), 20, 200}});
  }
  report.metrics = EvaluateTrajectory(report.groundtruth, report.trajectory);
  return report;
}

int ShowLive(int port) {
  RunReport begin;
  begin.title = "sample";
  std::string error;
  const auto live = LiveView::Start("127.0.0.1", port, begin, &error);
  if (!live) {
    std::cerr << error << std::endl;
    return 2;
  }
  const auto report = std::make_shared<const RunReport>(SampleReport(kFrames));
  size_t keyframes = 0;
  size_t positions = 0;
  for (const ReportFrame& frame : report->frames) {
    RunUpdate update;
    update.frames.push_back(frame);
    if (frame.is_tracked) {
      update.positions.push_back(report->trajectory[positions++].world_from_cam.translation());
    }
    if (frame.is_keyframe) {
      update.keyframes.push_back({static_cast<int>(keyframes), report->keyframes[keyframes]});
      ++keyframes;
    }
    live->Publish(std::move(update));
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  RunUpdate end;
  end.problems = FindProblems(report->frames);
  end.finished = report;
  live->Publish(std::move(end));
  return 0;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--live") return prism::ShowLive(std::atoi(argv[2]));
  if (argc != 2 && argc != 3) return 2;
  prism::WriteReport(argv[1], prism::SampleReport(argc == 3 ? std::atoi(argv[2]) : prism::kFrames));
  return 0;
}
