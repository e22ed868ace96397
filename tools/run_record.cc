// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/run_record.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include <nlohmann/json.hpp>

#include "prism/base/statistics.h"
#include "prism/base/version.h"
#include "tools/tool_main.h"
#include "tools/verdict_json.h"

namespace prism {
namespace {

// File names need not be UTF-8.
constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;

nlohmann::ordered_json KeyframeToJson(const KeyframeResult& keyframe) {
  const SolveResult& solve = keyframe.optimization.solve;
  nlohmann::ordered_json json = {{"status", ToString(keyframe.status)},
                                 {"converged", solve.converged},
                                 {"iterations", solve.iterations},
                                 {"initial_cost", solve.initial_cost},
                                 {"final_cost", solve.final_cost},
                                 {"points_dropped", keyframe.outliers.points_dropped}};
  if (const auto& known = keyframe.optimization.uncertainty) {
    json["scale_sigma"] = known->scale_sigma;
    if (known->depth_offset_sigma > 0) {
      json["depth_offset"] = known->depth_offset;
      json["depth_offset_sigma"] = known->depth_offset_sigma;
    }
  }
  for (size_t i = 0; i < keyframe.optimization.terms.size(); ++i) {
    const TermSummary& term = keyframe.optimization.terms[i];
    json["terms"][term.name] = {{"factors", term.factors},
                                {"variance_factor", term.variance_factor},
                                {"outliers", keyframe.outliers.factors_rejected[i]}};
  }
  return json;
}

// world_from_cam in the order of TUM files.
nlohmann::ordered_json PoseToJson(const SE3& world_from_cam) {
  const Eigen::Vector3d t = world_from_cam.translation();
  const Eigen::Quaterniond q = world_from_cam.rotation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

// `pose`: as it is known at the end; null: it is not.
nlohmann::ordered_json FrameToJson(const FrameResult& frame,
                                   const StampedPose* pose,
                                   const std::map<int64_t, std::string>& unreadable) {
  nlohmann::ordered_json json;
  json["time"] = 1e-9 * static_cast<double>(frame.time_ns);
  json["status"] = ToString(frame.status);
  json["segment"] = frame.segment;
  json["keyframe"] = frame.is_keyframe;
  if (frame.sigma.translation_m > 0) {
    json["position_sigma_m"] = frame.sigma.translation_m;
    json["rotation_sigma_deg"] = frame.sigma.rotation_rad * 180 / M_PI;
  }
  if (!HasPose(frame.status)) {
    const auto reason = unreadable.find(frame.time_ns);
    if (reason != unreadable.end()) json["reason"] = reason->second;
    if (frame.sigma.translation_m > 0) {
      json["pose_predicted"] = PoseToJson(frame.state.pose().Inverse());
    }
    return json;
  }
  json["pose_online"] = PoseToJson(frame.state.pose().Inverse());
  if (pose != nullptr) json["pose"] = PoseToJson(pose->world_from_cam);
  json["residual_rms"] = frame.rms;
  json["depth_agreement"] = frame.fit.depth_agreement;
  json["points_used"] = frame.points_used;
  json["active_points"] = frame.active_points;
  json["brightness_a"] = frame.state.a();
  json["brightness_b"] = frame.state.b();
  if (!frame.keyframe.optimization.terms.empty())
    json["optimization"] = KeyframeToJson(frame.keyframe);
  return json;
}

nlohmann::ordered_json SegmentsToJson(const std::vector<FrameResult>& frames,
                                      const std::map<int, int>& piece_of_segment) {
  nlohmann::ordered_json segments = nlohmann::ordered_json::array();
  for (const FrameResult& frame : frames) {
    if (!HasPose(frame.status)) continue;
    const double time = 1e-9 * static_cast<double>(frame.time_ns);
    if (segments.empty() || segments.back()["segment"] != frame.segment) {
      segments.push_back(
          {{"segment", frame.segment}, {"start", time}, {"end", time}, {"tracked_count", 0}});
      const auto piece = piece_of_segment.find(frame.segment);
      if (piece != piece_of_segment.end()) segments.back()["piece"] = piece->second;
    }
    segments.back()["end"] = time;
    segments.back()["tracked_count"] = segments.back()["tracked_count"].get<int>() + 1;
  }
  return segments;
}

nlohmann::ordered_json JoinsToJson(const std::vector<FrameResult>& frames) {
  nlohmann::ordered_json joins = nlohmann::ordered_json::array();
  for (const FrameResult& frame : frames) {
    if (!frame.joined) continue;
    joins.push_back({{"time", 1e-9 * static_cast<double>(frame.time_ns)},
                     {"segment", frame.joined->segment},
                     {"piece", frame.joined->piece},
                     {"new_world_from_old", PoseToJson(frame.joined->new_world_from_old)}});
  }
  return joins;
}

nlohmann::ordered_json CameraToJson(const std::string& path, const PlenopticCamera& camera) {
  nlohmann::ordered_json json;
  json["file"] = path;
  json["mode"] = ToString(camera.mode);
  json["focal_length_mm"] = 1e3 * camera.focal_length;
  json["main_lens_mla_distance_mm"] = 1e3 * camera.main_lens_mla_distance;
  json["sensor_mla_distance_mm"] = 1e3 * camera.sensor_mla_distance;
  json["focused_width_px"] = camera.focused_width();
  json["focused_height_px"] = camera.focused_height();
  json["focused_pixel_size_mm"] = 1e3 * camera.raw_pixel_size * camera.focused_scale;
  return json;
}

// Median over the keyframes of each term's variance factor.
std::map<std::string, double> MedianVarianceFactors(const std::vector<FrameResult>& frames) {
  std::map<std::string, std::vector<double>> values;
  for (const FrameResult& frame : frames) {
    for (const TermSummary& term : frame.keyframe.optimization.terms) {
      if (term.factors > 0) values[term.name].push_back(term.variance_factor);
    }
  }
  std::map<std::string, double> medians;
  for (const auto& [term, factors] : values) medians[term] = Quantile(factors, 0.5);
  return medians;
}

}  // namespace

int CountTracked(const std::vector<FrameResult>& frames) {
  return static_cast<int>(std::count_if(frames.begin(), frames.end(), [](const FrameResult& frame) {
    return HasPose(frame.status);
  }));
}

int CountKeyframes(const std::vector<FrameResult>& frames) {
  return static_cast<int>(std::count_if(
      frames.begin(), frames.end(), [](const FrameResult& frame) { return frame.is_keyframe; }));
}

std::vector<int64_t> SegmentStarts(const std::vector<FrameResult>& frames) {
  std::vector<int64_t> starts;
  int segment = 0;
  for (const FrameResult& frame : frames) {
    if (frame.segment == segment || !HasPose(frame.status)) continue;
    segment = frame.segment;
    starts.push_back(frame.time_ns);
  }
  return starts;
}

std::optional<ScaleSummary> SummarizeScale(const RunRecord& record) {
  ScaleSummary summary;
  double path = 0, weighted = 0;
  for (const FrameResult& frame : record.frames) {
    const auto& known = frame.keyframe.optimization.uncertainty;
    if (!known) continue;
    path += known->newest_step_m;
    weighted += known->newest_step_m * known->scale_sigma;
    summary.depth_offset = known->depth_offset;
    summary.depth_offset_sigma = known->depth_offset_sigma;
  }
  if (!(path > 0)) return std::nullopt;
  summary.sigma = weighted / path;
  summary.is_offset_told = summary.depth_offset_sigma < 0.7 * record.depth_offset_prior_sigma;
  return summary;
}

double ProcessorSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double PeakResidentMib() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

namespace {

// Without its frames.
nlohmann::ordered_json SummaryToJson(const RunRecord& record) {
  nlohmann::ordered_json json;
  const int tracked = CountTracked(record.frames);
  json["status"] = tracked == 0                                        ? "lost"
                   : tracked == static_cast<int>(record.frames.size()) ? "all tracked"
                                                                       : "partly tracked";
  json["end"] = record.end;
  if (!record.end_reason.empty()) json["end_reason"] = record.end_reason;
  json["version"] = kVersion;
  json["git_hash"] = GitRevision();
  json["options"] = record.options;
  json["camera"] = CameraToJson(record.camera_path, record.camera);
  json["format"] = record.sequence_format;
  json["input"] = record.input_report;
  if (!record.light_field.empty()) json["light_field"] = VerdictToJson(record.light_field);
  if (!record.notes.empty()) json["notes"] = record.notes;
  json["frame_count"] = record.frames.size();
  json["tracked_count"] = tracked;
  json["unreadable_count"] = record.unreadable.size();
  json["keyframe_count"] = CountKeyframes(record.frames);
  const double count = static_cast<double>(record.frames.size());
  json["wall_seconds"] = record.wall_seconds;
  json["frames_per_second"] = count / record.wall_seconds;
  json["processor_seconds"] = record.processor_seconds;
  json["processor_ms_per_frame"] = 1e3 * record.processor_seconds / count;
  json["peak_resident_mib"] = PeakResidentMib();
  json["variance_factors"] = MedianVarianceFactors(record.frames);  // by term
  json["intensity_sigma"] = record.intensity_sigma;
  json["depth_sigma_scale"] = record.depth_scale;
  json["keyframe_depth_offset_sigma"] = record.keyframe_depth_offset_sigma;
  if (const std::optional<ScaleSummary> scale = SummarizeScale(record)) {
    json["scale_sigma"] = scale->sigma;
    if (record.depth_offset_prior_sigma > 0) {
      json["depth_offset"] = {{"value", scale->depth_offset},
                              {"sigma", scale->depth_offset_sigma},
                              {"prior_sigma", record.depth_offset_prior_sigma},
                              {"is_told_by_scene", scale->is_offset_told}};
    }
  }
  json["segments"] = SegmentsToJson(record.frames, record.piece_of_segment);
  json["joins"] = JoinsToJson(record.frames);
  for (const auto& [stage, summary] : record.stages) {
    json["stages"][stage] = {{"count", summary.count},
                             {"median_ms", summary.median_ms},
                             {"p95_ms", summary.p95_ms},
                             {"total_ms", summary.total_ms}};
  }
  return json;
}

// All frames as values at once would take ten times as much memory as their text.
void WriteFrames(const RunRecord& record, std::ostream& stream) {
  stream << '[';
  size_t next_pose = 0;  // both lists are in the order of processing
  for (const FrameResult& frame : record.frames) {
    const bool has_pose = next_pose < record.trajectory.size() &&
                          record.trajectory[next_pose].time_ns == frame.time_ns;
    const nlohmann::ordered_json json =
        FrameToJson(frame, has_pose ? &record.trajectory[next_pose] : nullptr, record.unreadable);
    if (&frame != &record.frames.front()) stream << ',';
    stream << "\n  " << json.dump(-1, ' ', false, kReplace);
    next_pose += has_pose;
  }
  stream << "\n ]";
}

}  // namespace

void WriteJson(const RunRecord& record, std::ostream& stream) {
  std::string summary = SummaryToJson(record).dump(1, ' ', false, kReplace);
  summary.resize(summary.size() - 2);  // the end of the object
  stream << summary << ",\n \"frames\": ";
  WriteFrames(record, stream);
  stream << "\n}\n";
}

}  // namespace prism
