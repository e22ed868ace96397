// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/report_recorder.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "prism_git_revision.h"

namespace prism {
namespace {

constexpr int kThumbnailWidth_px = 512;

std::vector<std::pair<std::string, std::string>> DescribeCamera(const RunRecord& record) {
  const PlenopticCamera& camera = record.camera;
  const auto mm = [](double metres) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.4f mm", 1e3 * metres);
    return std::string(text);
  };
  return {{"file", record.camera_path},
          {"focal length f_L", mm(camera.focal_length)},
          {"main lens to micro lenses b_L0", mm(camera.main_lens_mla_distance)},
          {"micro lenses to sensor B", mm(camera.sensor_mla_distance)},
          {"focused image",
           std::to_string(camera.focused_width()) + " x " +
               std::to_string(camera.focused_height()) + " px"}};
}

}  // namespace

void ReportRecorder::Add(const FrameResult& frame, const Odometry& odometry) {
  ReportFrame entry;
  entry.time_ns = frame.time_ns;
  entry.status = ToString(frame.status);
  entry.is_tracked = frame.status == FrameStatus::kTracked;
  entry.is_keyframe = frame.is_keyframe;
  entry.segment = frame.segment;
  entry.residual_rms = frame.rms;
  entry.points = frame.points_used;
  entry.brightness_a = frame.state.a();
  entry.brightness_b = frame.state.b();
  entry.stage_ms = TakeStageTimes(odometry.timer());
  if (entry.is_tracked) positions_.push_back(frame.state.pose().Inverse().translation());
  frames_.push_back(std::move(entry));
  if (frame.is_keyframe) UpdateKeyframes(odometry.window());
}

std::map<std::string, double> ReportRecorder::TakeStageTimes(const StageTimer& timer) {
  std::map<std::string, double> times_ms;
  for (const auto& [stage, durations_ms] : timer.durations_ms()) {
    size_t& taken = times_taken_[stage];
    for (; taken < durations_ms.size(); ++taken) times_ms[stage] += durations_ms[taken];
  }
  return times_ms;
}

void ReportRecorder::UpdateKeyframes(const Window& window) {
  for (const auto& keyframe : window.keyframes) {
    ReportKeyframe& entry = keyframes_[keyframe->id];
    const ImageF& image = keyframe->frame->image[0];
    if (entry.jpeg.empty()) {
      entry.time_ns = keyframe->frame->time_ns;
      SetThumbnail(image, kThumbnailWidth_px, &entry);
    }
    const double factor = static_cast<double>(entry.width) / image.width();
    entry.world_from_cam = keyframe->state.pose().Inverse();
    entry.points.clear();
    for (const auto& point : keyframe->points) {
      if (point->rho <= 0) continue;
      const Eigen::Vector2d px =
          (point->patch.px + Eigen::Vector2d(0.5, 0.5)) * factor - Eigen::Vector2d(0.5, 0.5);
      entry.points.push_back({static_cast<float>(px.x()),
                              static_cast<float>(px.y()),
                              static_cast<float>(1 / point->rho)});
    }
  }
}

nlohmann::json ReportRecorder::TakeUpdate() {
  nlohmann::json update = {{"frames", nlohmann::json::array()},
                           {"trajectory", nlohmann::json::array()},
                           {"keyframes", nlohmann::json::array()},
                           {"problems", FindProblems(frames_)}};
  for (; frames_taken_ < frames_.size(); ++frames_taken_) {
    update["frames"].push_back(FrameToReportJson(frames_[frames_taken_]));
  }
  for (; positions_taken_ < positions_.size(); ++positions_taken_) {
    for (int i = 0; i < 3; ++i) update["trajectory"].push_back(positions_[positions_taken_](i));
  }
  for (auto next = keyframes_.upper_bound(last_keyframe_taken_); next != keyframes_.end(); ++next) {
    update["keyframes"].push_back(KeyframeToReportJson(next->second));
    last_keyframe_taken_ = next->first;
  }
  return update;
}

RunReport DescribeRun(const RunRecord& record) {
  RunReport report;
  const auto sequence = record.options.find("sequence");
  if (sequence != record.options.end()) {
    const std::filesystem::path path = std::filesystem::absolute(sequence->second);
    report.title = (path.has_filename() ? path : path.parent_path()).filename().string();
  }
  report.git_hash = PRISM_GIT_REVISION;
  report.options = record.options;
  report.camera = DescribeCamera(record);
  return report;
}

RunReport ReportRecorder::Finish(const RunRecord& record,
                                 const Odometry& odometry,
                                 const Trajectory& groundtruth) const {
  RunReport report = DescribeRun(record);
  report.wall_seconds = record.wall_seconds;
  report.peak_resident_mib = PeakResidentMib();
  report.frames = frames_;
  report.trajectory = odometry.FrameTrajectory();
  for (const auto& [id, keyframe] : keyframes_) report.keyframes.push_back(keyframe);
  for (const MapPoint& point : odometry.MapPoints()) {
    report.cloud.push_back({point.p_in_world.cast<float>(),
                            static_cast<uint8_t>(std::clamp(point.intensity, 0.0f, 255.0f))});
  }
  if (!groundtruth.empty()) {
    report.groundtruth = groundtruth;
    EvaluationOptions options;
    options.segment_starts_ns = SegmentStarts(record.frames);
    report.metrics = EvaluateTrajectory(groundtruth, report.trajectory, options);
  }
  return report;
}

}  // namespace prism
