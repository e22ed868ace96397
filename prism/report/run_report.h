// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "prism/eval/metrics.h"
#include "prism/report/keyframe_images.h"
#include "prism/scene/trajectory.h"

namespace prism {

struct ReportFrame {
  int64_t time_ns = 0;
  std::string status;  // any text; shown where the frame was not tracked
  bool is_tracked = false;
  bool is_keyframe = false;
  int segment = 0;
  bool is_held = false;    // tracked, on little and on the motion before
  bool is_joined = false;  // with this frame its segment was found to be part of what was before
  // Only of tracked frames.
  double residual_rms = 0;                 // intensities, 0 to 255
  int points = 0;                          // used by the alignment
  double brightness_a = 0;                 // affine brightness, log gain and offset
  double brightness_b = 0;                 // intensities
  std::map<std::string, double> stage_ms;  // time spent on this frame, by stage
  // Relative, of the metric scale, as stated by the window of a keyframe; 0: not known.
  double scale_sigma = 0;
};

struct ReportCloudPoint {
  Eigen::Vector3f p_in_world = Eigen::Vector3f::Zero();  // metres
  std::array<uint8_t, 3> rgb{};
};

// All that report.html shows of a run. World is the one of `trajectory`.
struct RunReport {
  std::string title;
  std::string git_hash;
  std::vector<std::string> notes;  // what was found and assumed of the input
  double wall_seconds = 0;
  double processor_seconds = 0;
  double peak_resident_mib = 0;
  std::map<std::string, std::string> options;
  std::vector<std::pair<std::string, std::string>> camera;  // name (with unit) and value
  std::vector<ReportFrame> frames;                          // in order of time
  Trajectory trajectory;                                    // tracked frames
  // Of each of them the piece of the map it belongs to; empty: there is one.
  std::vector<int> pieces;
  std::vector<ReportKeyframe> keyframes;  // in order of time; some may have no image and points
  // Tangents of half the angles of view of their images; 0: not known.
  double view_x = 0;
  double view_y = 0;
  std::vector<ReportCloudPoint> cloud;       // the points of the odometry
  std::vector<ReportCloudPoint> dense;       // fused depth of the keyframes; empty: none
  std::optional<double> scale_sigma;         // relative, of the metric scale of the whole path
  Trajectory groundtruth;                    // in its own world; empty: none
  std::optional<TrajectoryMetrics> metrics;  // of trajectory against groundtruth
};

// What went wrong, and what became of it: "frames 12 to 15 not tracked (no texture)", "2 of 3
// segments were joined to what was before". At most 50 lines.
std::vector<std::string> FindProblems(const std::vector<ReportFrame>& frames);

// The data of the page, bounded however long the run was, so that the page has less than 20 MB.
// What is too much is left out evenly (frames, poses, points, pictures of keyframes); `left_out`
// says so, a line each.
nlohmann::json ReportToJson(const RunReport& report);
nlohmann::json FrameToReportJson(const ReportFrame& frame);
// Without image and size if the keyframe has no image.
nlohmann::json KeyframeToReportJson(const ReportKeyframe& keyframe);

// The whole page as one HTML text with all scripts and styles inside; it needs no network. `live`:
// the page asks the server it came from for what happens further (see live_view.h).
std::string FormatReport(const RunReport& report, bool live = false);

// Writes FormatReport, whole or not at all. Throws InputError if that cannot be done.
void WriteReport(const std::string& path, const RunReport& report);

}  // namespace prism
