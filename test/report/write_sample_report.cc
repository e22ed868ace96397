// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// write_sample_report PATH: a report as a run of 228 frames would leave it, made up, for the test
// in a browser. write_sample_report --live PORT: the same run as it goes on, in a second.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
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
  SetThumbnail(image, 512, &keyframe);
  std::uniform_real_distribution<float> pixel(0, 511);
  std::uniform_real_distribution<float> depth_m(0.8f, 4);
  for (int k = 0; k < 400; ++k) {
    keyframe.points.push_back({pixel(*generator), pixel(*generator), depth_m(*generator)});
  }
  return keyframe;
}

RunReport SampleReport() {
  std::mt19937 generator(7);
  RunReport report;
  report.title = "sample </script> & <run>";
  report.git_hash = "0123456789ab";
  report.wall_seconds = 10;
  report.processor_seconds = 18;
  report.options = {{"sequence", "sample"}, {"threads", "2"}};
  report.camera = {{"focal length", "16.7 mm"}};
  for (int i = 0; i < kFrames; ++i) {
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
    if (i >= 50) frame.stage_ms["realign"] = 2;
    if (frame.is_tracked) report.trajectory.push_back({time_ns, PoseAt(i, 0.97)});
    if (frame.is_keyframe) report.keyframes.push_back(KeyframeAt(i, &generator));
    if (i == kWithoutImage) report.keyframes.back().jpeg = "";
    report.frames.push_back(frame);
  }
  std::uniform_real_distribution<float> coordinate(-2, 2);
  for (int k = 0; k < 100000; ++k) {
    report.cloud.push_back(
        {{coordinate(generator), coordinate(generator), 2 + coordinate(generator)},
         static_cast<uint8_t>(k % 256)});
  }
  report.metrics = EvaluateTrajectory(report.groundtruth, report.trajectory);
  return report;
}

int ShowLive(int port) {
  const auto report = std::make_shared<const RunReport>(SampleReport());
  RunReport begin;
  begin.title = report->title;
  std::string error;
  const auto live = LiveView::Start("127.0.0.1", port, begin, &error);
  if (!live) {
    std::cerr << error << std::endl;
    return 2;
  }
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
  if (argc != 2) return 2;
  prism::WriteReport(argv[1], prism::SampleReport());
  return 0;
}
