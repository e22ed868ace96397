// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/run_output.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <ostream>
#include <vector>

#include "prism/base/error.h"
#include "prism/eval/metrics.h"
#include "prism/io/atomic_file.h"
#include "prism/io/map_file.h"
#include "prism/io/ply_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/report/metrics_json.h"

namespace prism {
namespace {

namespace fs = std::filesystem;

constexpr char kPiecePrefix[] = "trajectory_segment";

// Of an earlier run, or of an earlier moment of this one.
void RemovePieces(const std::string& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename().string().rfind(kPiecePrefix, 0) == 0) fs::remove(entry.path());
  }
}

std::vector<PlyPoint> PlyPoints(const Map& map, const Window& window) {
  std::vector<PlyPoint> points;
  points.reserve(map.CountPoints(window));
  map.ForEachPoint(window, [&](const MapPoint& point) {
    points.push_back({point.p_in_world.cast<float>(), point.rgb});
  });
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
  if (metrics.status != EvaluationStatus::kDone) {
    std::printf("ground truth: no errors, %s (%d poses matched)\n",
                ToString(metrics.status),
                metrics.matched_count);
    return;
  }
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
    if (!HasPose(frame.status)) continue;
    trajectory.push_back({frame.time_ns, frame.state.pose().Inverse()});
  }
  return trajectory;
}

// Of the pieces of a map that could not be joined, by the number of the first segment of each.
void WritePieces(const std::string& folder, const Map& map, const PlayOrder& play_order) {
  RemovePieces(folder);
  const std::vector<int> pieces = map.Pieces();
  if (pieces.size() < 2) return;
  for (const int piece : pieces) {
    WriteTrajectory(InFolder(folder, kPiecePrefix + std::to_string(piece) + ".txt"),
                    play_order.InFileTimes(map.FrameTrajectory(piece)));
  }
}

// Does all of them, and throws the first error then: one file that cannot be written costs no
// other.
void DoAll(const std::vector<std::function<void()>>& actions) {
  std::exception_ptr first_error;
  for (const auto& action : actions) {
    try {
      action();
    } catch (const InputError&) {
      if (!first_error) first_error = std::current_exception();
    }
  }
  if (first_error) std::rethrow_exception(first_error);
}

void PrintSegments(const RunRecord& record, const Map& map) {
  int joined = 0, held = 0;
  for (const FrameResult& frame : record.frames) {
    joined += frame.joined.has_value();
    held += frame.status == FrameStatus::kHeld;
  }
  if (held > 0) std::printf("%d frames show little and are held by the motion before them\n", held);
  if (joined > 0) std::printf("%d times a segment was found to continue what was before\n", joined);
  const size_t pieces = map.Pieces().size();
  if (pieces > 1) {
    std::printf("%zu segments could not be joined: trajectory_segmentN.txt has each by itself\n",
                pieces);
  }
}

}  // namespace

void ClearResults(const std::string& folder) {
  try {
    RemovePieces(folder);
    for (const char* name : {"run.json",
                             "trajectory.txt",
                             "keyframes.txt",
                             "points.ply",
                             "trajectory_closed.txt",
                             "keyframes_closed.txt",
                             "points_closed.ply",
                             "metrics.json",
                             "report.html",
                             "refined_camera.yaml"}) {
      fs::remove(InFolder(folder, name));
    }
  } catch (const fs::filesystem_error& error) {
    throw InputError(error.path1().string(),
                     "a file of an earlier run (" + error.code().message() + ")",
                     "one that can be removed");
  }
}

void WritePoses(const std::string& folder, const Odometry& odometry, const PlayOrder& play_order) {
  DoAll({[&] {
           WriteTrajectory(InFolder(folder, "trajectory.txt"),
                           play_order.InFileTimes(odometry.FrameTrajectory()));
         },
         [&] { WritePieces(folder, odometry.map(), play_order); },
         [&] {
           WriteTrajectory(InFolder(folder, "keyframes.txt"),
                           play_order.InFileTimes(odometry.KeyframeTrajectory()));
         }});
}

void WriteRun(const std::string& folder,
              const RunRecord& record,
              const Odometry& odometry,
              const PlayOrder& play_order) {
  DoAll({[&] { WritePoses(folder, odometry, play_order); },
         [&] {
           WritePly(InFolder(folder, "points.ply"), PlyPoints(odometry.map(), odometry.window()));
         },
         [&] {
           WriteStreamAtomically(InFolder(folder, "run.json"),
                                 [&](std::ostream& stream) { WriteJson(record, stream); });
         }});
}

void PrintRun(const std::string& folder, const RunRecord& record, const Odometry& odometry) {
  std::printf(
      "\n%d of %zu frames tracked, %d keyframes, %.1f frames a second, %.0f MiB, results in %s\n",
      CountTracked(record.frames),
      record.frames.size(),
      CountKeyframes(record.frames),
      static_cast<double>(record.frames.size()) / record.wall_seconds,
      PeakResidentMib(),
      folder.c_str());
  PrintSegments(record, odometry.map());
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
    if (record.camera.focused_image == FocusedImage::kChiefRays) {
      std::printf(
          "  if the camera's b_L0 is a guess, calibrate it (prism_calibrate), or try "
          "--focused_image=virtual_points\n");
    }
  }
  if (poor + not_solved > 0) {
    std::printf("of the keyframes' windows %d fit poorly, %d could not be solved (run.json)\n",
                poor,
                not_solved);
  }
}

void PrintEnd(const RunRecord& record) {
  if (record.end == "interrupted") {
    std::printf("interrupted by %s after %zu frames; all up to there is written\n",
                record.end_reason.c_str(),
                record.frames.size());
  }
  const int tracked = CountTracked(record.frames);
  if (2 * tracked < static_cast<int>(record.frames.size())) {
    std::printf("fewer than half of the frames were tracked\n");
  }
  if (!record.unreadable.empty()) {
    std::printf("%zu of %zu frames could not be read (run.json says why)\n",
                record.unreadable.size(),
                record.frames.size());
  }
}

void WriteClosedMap(const std::string& folder,
                    const Odometry& odometry,
                    const PlayOrder& play_order,
                    const Trajectory& groundtruth) {
  Map map = odometry.map();
  const int loops = map.CloseLoops();
  WriteTrajectory(InFolder(folder, "trajectory_closed.txt"),
                  play_order.InFileTimes(map.FrameTrajectory()));
  WriteTrajectory(InFolder(folder, "keyframes_closed.txt"),
                  play_order.InFileTimes(map.KeyframeTrajectory()));
  WritePly(InFolder(folder, "points_closed.ply"), PlyPoints(map, odometry.window()));
  std::printf("%d views of places seen before close loops (*_closed.*)\n", loops);
  if (groundtruth.empty()) return;
  const TrajectoryMetrics before = EvaluateTrajectory(groundtruth, odometry.FrameTrajectory(), {});
  const TrajectoryMetrics closed = EvaluateTrajectory(groundtruth, map.FrameTrajectory(), {});
  if (closed.status != EvaluationStatus::kDone) return;
  std::printf(
      "  ATE %.4f m (SE3) with loops closed, %.4f m without", closed.ate_rmse_m, before.ate_rmse_m);
  if (closed.loop && before.loop) {
    std::printf("; e_align %.4f m, %.4f m", closed.loop->e_align_m, before.loop->e_align_m);
  }
  std::printf("\n");
}

void SaveMap(const std::string& folder, const Odometry& odometry) {
  const Map map = odometry.CompleteMap();
  const int piece = map.Pieces().front();
  const bool is_found = !map.HasLoadedPlaces() || piece == kLoadedSegment;
  if (!is_found && std::filesystem::exists(InFolder(folder, "map.yml"))) {
    std::printf("map not saved: the run was not found in the one loaded, and %s holds one\n",
                folder.c_str());
    return;
  }
  const std::vector<MappedPlace> places = map.MappedPlaces(piece);
  WriteMap(folder, odometry.window().camera, places);
  const size_t left_out = map.places().size() - places.size();
  std::printf("map of %zu places saved to %s", places.size(), folder.c_str());
  if (left_out > 0) std::printf("; %zu that are not joined to it are left out", left_out);
  std::printf("\n");
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
  if (online.status != EvaluationStatus::kDone) return;
  std::printf("poses as they were known when each frame came: ATE %.4f m (SE3)\n",
              online.ate_rmse_m);
}

}  // namespace prism
