// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/run_output.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "prism/eval/metrics.h"
#include "prism/io/atomic_file.h"
#include "prism/io/ply_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/report/metrics_json.h"

namespace prism {
namespace {

std::string InFolder(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

std::vector<PlyPoint> PlyPoints(const std::vector<MapPoint>& map_points) {
  std::vector<PlyPoint> points;
  for (const MapPoint& point : map_points) {
    points.push_back({point.p_in_world.cast<float>(), point.rgb});
  }
  return points;
}

void PrintScale(const RunRecord& record) {
  const std::optional<ScaleSummary> scale = SummarizeScale(record);
  if (!scale) return;
  std::printf("metric scale known to %.2f %% (1 sigma)", 100 * scale->sigma);
  if (record.depth_offset_prior_sigma > 0) {
    std::printf(", measured 1/v off by %.5f +- %.5f%s",
                scale->depth_offset,
                scale->depth_offset_sigma,
                scale->is_offset_told ? "" : " (the scene does not tell it from the scale)");
  }
  std::printf("\n");
}

void PrintMetrics(const TrajectoryMetrics& metrics) {
  std::printf("ground truth: %d poses matched, ATE %.4f m (SE3)",
              metrics.matched_count,
              metrics.ate_rmse_m);
  if (metrics.sim3) {
    std::printf(", %.4f m (Sim3), scale %.4f (error %.2f %%)",
                metrics.sim3->ate_rmse_m,
                metrics.sim3->scale,
                metrics.sim3->scale_error_percent);
  }
  std::printf(", path %.3f m\n", metrics.path_length_m);
  if (metrics.segments.size() < 2) return;
  for (const SegmentMetrics& segment : metrics.segments) {
    std::printf("  segment from %.3f s to %.3f s: %d poses",
                1e-9 * static_cast<double>(segment.start_ns),
                1e-9 * static_cast<double>(segment.end_ns),
                segment.matched_count);
    if (segment.ate_rmse_m) std::printf(", ATE %.4f m", *segment.ate_rmse_m);
    if (segment.scale) std::printf(", scale %.4f", *segment.scale);
    std::printf(", path %.3f m\n", segment.path_length_m);
  }
}

// Frames by the poses that Process returned for them.
Trajectory OnlineTrajectory(const std::vector<FrameResult>& frames) {
  Trajectory trajectory;
  for (const FrameResult& frame : frames) {
    if (frame.status != FrameStatus::kTracked) continue;
    trajectory.push_back({frame.time_ns, frame.state.pose().Inverse()});
  }
  return trajectory;
}

}  // namespace

void WriteRun(const std::string& folder,
              const RunRecord& record,
              const Odometry& odometry,
              const PlayOrder& play_order) {
  WriteTrajectory(InFolder(folder, "trajectory.txt"),
                  play_order.InFileTimes(odometry.FrameTrajectory()));
  WriteTrajectory(InFolder(folder, "keyframes.txt"),
                  play_order.InFileTimes(odometry.KeyframeTrajectory()));
  WritePly(InFolder(folder, "points.ply"), PlyPoints(odometry.MapPoints()));
  WriteTextAtomically(InFolder(folder, "run.json"), RunToJson(record).dump(1) + "\n");
  std::printf(
      "\n%d of %zu frames tracked, %d keyframes, %.1f frames a second, %.0f MiB, results in %s\n",
      CountTracked(record.frames),
      record.frames.size(),
      CountKeyframes(record.frames),
      static_cast<double>(record.frames.size()) / record.wall_seconds,
      PeakResidentMib(),
      folder.c_str());
  PrintScale(record);
  int poor = 0, not_solved = 0, disagreeing = 0;
  for (const FrameResult& frame : record.frames) {
    disagreeing += frame.status == FrameStatus::kDepthsDisagree;
    poor += frame.keyframe.status == KeyframeStatus::kPoorFit;
    not_solved += frame.keyframe.status == KeyframeStatus::kNotSolved;
  }
  if (disagreeing > 0) {
    std::printf("%d frames match the images, but not the depths they measure: not taken\n",
                disagreeing);
  }
  if (poor + not_solved > 0) {
    std::printf("of the keyframes' windows %d fit poorly, %d could not be solved (run.json)\n",
                poor,
                not_solved);
  }
}

void WriteMetrics(const std::string& folder,
                  const RunRecord& record,
                  const Odometry& odometry,
                  const Trajectory& groundtruth) {
  EvaluationOptions options;
  options.segment_starts_ns = SegmentStarts(record.frames);
  const TrajectoryMetrics metrics =
      EvaluateTrajectory(groundtruth, odometry.FrameTrajectory(), options);
  const TrajectoryMetrics online =
      EvaluateTrajectory(groundtruth, OnlineTrajectory(record.frames), options);
  nlohmann::ordered_json json = MetricsToJson(metrics);
  json["ate_online_rmse_m"] = MetricsToJson(online)["ate_rmse_m"];
  WriteTextAtomically(InFolder(folder, "metrics.json"), json.dump(1) + "\n");
  PrintMetrics(metrics);
  std::printf("poses as they were known when each frame came: ATE %.4f m (SE3)\n",
              online.ate_rmse_m);
}

}  // namespace prism
