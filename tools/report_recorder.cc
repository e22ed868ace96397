// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/report_recorder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <set>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "prism/export/dense_points.h"
#include "prism/factors/photometric.h"
#include "prism/factors/visibility.h"
#include "tools/tool_main.h"

namespace prism {
namespace {

constexpr int kThumbnailWidth_px = 512;
constexpr int kDepthMapWidth_px = 256;

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
          {"mode", ToString(camera.mode)},
          {"focused image",
           std::to_string(camera.focused_width()) + " x " +
               std::to_string(camera.focused_height()) + " px"}};
}

// RMS of the photometric residuals of a point, weighted by DSO's gradient weights, over the frames
// of the window that see it; intensities. NaN: none does.
float ResidualRms(const Window& window,
                  const Keyframe& host,
                  const std::vector<FramePair>& pairs,
                  const Point& point) {
  double sum = 0;
  int count = 0;
  for (size_t j = 0; j < window.keyframes.size(); ++j) {
    const Keyframe& target = *window.keyframes[j];
    PatternMatch match;
    if (&target == &host || IsHidden(point, target) ||
        !EvaluatePattern(
            point.patch, pairs[j], target.frame->image[0], window.camera, point.rho, &match)) {
      continue;
    }
    sum += match.residuals.squaredNorm() / (pairs[j].inverse_sigma * pairs[j].inverse_sigma);
    count += kPatternSize;
  }
  return count > 0 ? static_cast<float>(std::sqrt(sum / count))
                   : std::numeric_limits<float>::quiet_NaN();
}

// Of a keyframe of the window, on its thumbnail.
std::vector<ReportKeyframe::Point> PointsOf(const Window& window, const Keyframe& keyframe) {
  std::vector<FramePair> pairs;
  for (const auto& target : window.keyframes) {
    pairs.push_back(MakeFramePair(window.noise, keyframe.state, target->state));
  }
  const double factor = ThumbnailFactor(keyframe.frame->image[0].width(), kThumbnailWidth_px);
  std::vector<ReportKeyframe::Point> points;
  for (const auto& point : keyframe.points) {
    if (point->rho <= 0) continue;
    const Eigen::Vector2d px =
        (point->patch.px + Eigen::Vector2d(0.5, 0.5)) * factor - Eigen::Vector2d(0.5, 0.5);
    points.push_back({static_cast<float>(px.x()),
                      static_cast<float>(px.y()),
                      static_cast<float>(1 / point->rho),
                      ResidualRms(window, keyframe, pairs, *point)});
  }
  return points;
}

}  // namespace

void ReportRecorder::Add(const FrameResult& frame,
                         const Odometry& odometry,
                         const StageTimer& reading) {
  ReportFrame entry;
  entry.time_ns = frame.time_ns;
  entry.status = ToString(frame.status);
  entry.is_tracked = HasPose(frame.status);
  entry.is_keyframe = frame.is_keyframe;
  entry.segment = frame.segment;
  entry.is_held = frame.status == FrameStatus::kHeld;
  entry.is_joined = frame.joined.has_value();
  entry.residual_rms = frame.rms;
  entry.points = frame.points_used;
  entry.brightness_a = frame.state.a();
  entry.brightness_b = frame.state.b();
  if (const auto& known = frame.keyframe.optimization.uncertainty) {
    entry.scale_sigma = known->scale_sigma;
  }
  entry.stage_ms = TakeNewTimes(reading, &reading_totals_);
  entry.stage_ms.merge(TakeNewTimes(odometry.timer(), &odometry_totals_));
  if (entry.is_tracked) positions_.push_back(frame.state.pose().Inverse().translation());
  frames_.push_back(std::move(entry));
  if (frame.is_keyframe) {
    UpdateKeyframes(odometry);
    ThinOutPictures(odometry.window());
  }
  if (frame.joined || frame.has_settled) MoveKeyframes(odometry.map());
}

void ReportRecorder::MoveKeyframes(const Map& map) {
  for (auto& [id, entry] : keyframes_) {
    entry.keyframe.world_from_cam = map.CamFromWorld(id).Inverse();
    entry.has_changed = true;
  }
}

void ReportRecorder::UpdateKeyframes(const Odometry& odometry) {
  for (const auto& keyframe : odometry.window().keyframes) {
    const auto [position, is_new] = keyframes_.try_emplace(keyframe->id);
    Entry& entry = position->second;
    if (is_new) {
      entry.keyframe.time_ns = keyframe->frame->time_ns;
      entry.pictures = std::async(std::launch::async, [frame = keyframe->frame]() mutable {
        Pictures pictures = MakePictures(*frame);
        frame.reset();  // the future would hold it
        return pictures;
      });
    }
    entry.keyframe.world_from_cam = odometry.map().CamFromWorld(keyframe->id).Inverse();
    std::vector<ReportKeyframe::Point> points = PointsOf(odometry.window(), *keyframe);
    entry.most_points = std::max(entry.most_points, points.size());
    if (2 * points.size() >= entry.most_points) entry.keyframe.points = std::move(points);
    entry.has_changed = true;
  }
}

void ReportRecorder::ThinOutPictures(const Window& window) {
  while (keyframes_.size() > kMaxPictures * picture_step_) picture_step_ *= 2;
  std::set<int> in_window;
  for (const auto& keyframe : window.keyframes) in_window.insert(keyframe->id);
  size_t number = 0;
  for (auto& [id, entry] : keyframes_) {
    if (number++ % picture_step_ == 0 || in_window.count(id) > 0) continue;
    entry.pictures = {};
    entry.depth = {};
    entry.keyframe.DropPictures();
  }
}

ReportRecorder::Pictures ReportRecorder::MakePictures(const LightFieldFrame& frame) {
  Pictures pictures;
  const cv::Mat thumbnail = MakeThumbnail(frame.image[0], frame.colour, kThumbnailWidth_px);
  SetThumbnail(thumbnail, &pictures.keyframe);
  const SmallDepth depth =
      MakeSmallDepth(frame.inverse_virtual_depth, frame.sigma, kDepthMapWidth_px);
  SetDepthMaps(depth, &pictures.keyframe);
  LightFieldFrame small;
  small.inverse_virtual_depth = depth.inverse_virtual_depth;
  small.sigma = depth.sigma;
  cv::Mat image;
  const cv::Size size(depth.sigma.width(), depth.sigma.height());
  cv::resize(thumbnail, image, size, 0, 0, cv::INTER_AREA);
  small.colour = image;  // gray or in colour: it is only encoded
  small.image.emplace_back(size.width, size.height, 0);
  EncodeFrame(small, &pictures.depth);
  return pictures;
}

bool ReportRecorder::TakePictures(bool wait, Entry* entry) {
  if (!entry->pictures.valid()) return true;
  if (!wait && entry->pictures.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return false;
  }
  Pictures pictures = entry->pictures.get();
  entry->depth = std::move(pictures.depth);
  pictures.keyframe.time_ns = entry->keyframe.time_ns;
  pictures.keyframe.world_from_cam = entry->keyframe.world_from_cam;
  pictures.keyframe.points = std::move(entry->keyframe.points);
  entry->keyframe = std::move(pictures.keyframe);
  return true;
}

std::vector<ReportCloudPoint> ReportRecorder::FuseDepthMaps(const RunRecord& record,
                                                            const Map& map) const {
  const double factor = ThumbnailFactor(record.camera.focused_width(), kDepthMapWidth_px);
  std::map<int, ExportRun> runs;  // by piece
  for (const auto& [id, entry] : keyframes_) {
    if (entry.depth.depth.empty()) continue;
    ExportRun& run = runs[map.Piece(map.SegmentOf(id))];
    run.keyframes.push_back(entry.depth);
    run.keyframes.back().world_from_cam = entry.keyframe.world_from_cam;
  }
  std::vector<ReportCloudPoint> cloud;
  for (auto& [piece, run] : runs) {
    run.camera =
        PlenopticProjection(record.camera, static_cast<int>(std::lround(-std::log2(factor))));
    for (const OrientedPoint& point : FuseDepth(run)) cloud.push_back({point.position, point.rgb});
  }
  return cloud;
}

RunUpdate ReportRecorder::TakeUpdate(bool is_last) {
  RunUpdate update;
  update.frames.assign(frames_.begin() + static_cast<std::ptrdiff_t>(frames_taken_), frames_.end());
  update.positions.assign(positions_.begin() + static_cast<std::ptrdiff_t>(positions_taken_),
                          positions_.end());
  frames_taken_ = frames_.size();
  positions_taken_ = positions_.size();
  int index = 0;
  for (auto& [id, entry] : keyframes_) {
    if (entry.has_changed && !TakePictures(is_last, &entry)) break;
    if (entry.has_changed) {
      update.keyframes.push_back({index, entry.keyframe});
      if (entry.is_told) {  // the browser keeps them
        update.keyframes.back().keyframe.jpeg.clear();
        update.keyframes.back().keyframe.inverse_virtual_depth = {};
        update.keyframes.back().keyframe.sigma = {};
      }
      entry.is_told = true;
      entry.has_changed = false;
    }
    ++index;
  }
  const std::vector<std::string> problems = FindProblems(frames_);
  const bool is_last_tracked = frames_.empty() || frames_.back().is_tracked;
  if (problems.size() != problems_taken_ || !is_last_tracked) update.problems = problems;
  problems_taken_ = problems.size();
  return update;
}

RunReport DescribeRun(const RunRecord& record) {
  RunReport report;
  const auto sequence = record.options.find("sequence");
  if (sequence != record.options.end()) {
    const std::filesystem::path path = std::filesystem::absolute(sequence->second);
    report.title = (path.has_filename() ? path : path.parent_path()).filename().string();
  }
  report.git_hash = GitRevision();
  report.options = record.options;
  report.notes = record.input_report;
  report.camera = DescribeCamera(record);
  return report;
}

RunReport ReportRecorder::Finish(const RunRecord& record,
                                 const Odometry& odometry,
                                 const Trajectory& groundtruth) && {
  RunReport report = DescribeRun(record);
  report.wall_seconds = record.wall_seconds;
  report.processor_seconds = record.processor_seconds;
  report.peak_resident_mib = PeakResidentMib();
  report.frames = std::move(frames_);
  report.trajectory = odometry.FrameTrajectory();
  if (odometry.map().Pieces().size() > 1) report.pieces = odometry.map().PiecesOfFrames();
  for (auto& [id, entry] : keyframes_) TakePictures(true, &entry);
  report.dense = FuseDepthMaps(record, odometry.map());
  for (auto& [id, entry] : keyframes_) report.keyframes.push_back(std::move(entry.keyframe));
  report.cloud.reserve(odometry.map().CountPoints(odometry.window()));
  odometry.map().ForEachPoint(odometry.window(), [&](const MapPoint& point) {
    report.cloud.push_back({point.p_in_world.cast<float>(), point.rgb});
  });
  const PlenopticProjection camera(record.camera);
  report.view_x = 0.5 * camera.width / camera.FocalLengthPx();
  report.view_y = 0.5 * camera.height / camera.FocalLengthPx();
  if (const std::optional<ScaleSummary> scale = SummarizeScale(record)) {
    report.scale_sigma = scale->sigma;
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
