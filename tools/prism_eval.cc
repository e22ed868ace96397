// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include <gflags/gflags.h>

#include "prism/base/error.h"
#include "prism/eval/metrics.h"
#include "prism/io/atomic_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/report/metrics_json.h"
#include "prism/report/metrics_table.h"
#include "prism/report/plot.h"
#include "prism/report/trajectory_plots.h"
#include "tools/tool_main.h"

DEFINE_string(groundtruth, "", "True trajectory (TUM, EuRoC CSV or KITTI)");
DEFINE_string(estimate, "", "Estimated trajectories, with commas between them");
DEFINE_string(label, "", "Their names in tables and plots, with commas; default: from the paths");
DEFINE_string(format, "auto", "Of all files: auto, tum, euroc or kitti");
DEFINE_string(kitti_times, "", "File with the times of KITTI poses, one in seconds a line");
DEFINE_double(kitti_rate_hz, 0, "Or the rate of KITTI poses");
DEFINE_double(max_time_difference_s, 0, "Largest difference of a match; 0: half a frame");
DEFINE_double(relative_interval_s, 1, "Time over which relative errors are taken");
DEFINE_double(loop_segment_fraction, 0.2, "Start and end segment of e_s, e_r, e_align, 0 to 0.5");
DEFINE_double(segment_gap_s, 1, "A gap in an estimate longer than this begins a new segment");
DEFINE_string(json, "", "Write the metrics here as JSON");
DEFINE_string(csv, "", "Write the table here as CSV");
DEFINE_string(latex, "", "Write the table here as rows of a LaTeX tabular");
DEFINE_string(plot_dir, "", "Write plots here as PDF, SVG and PNG");

namespace prism {
namespace {

TrajectoryReadOptions ReadOptionsFromFlags() {
  TrajectoryReadOptions options;
  options.kitti_times_path = FLAGS_kitti_times;
  options.kitti_rate_hz = FLAGS_kitti_rate_hz;
  if (FLAGS_format == "tum") {
    options.format = TrajectoryFormat::kTum;
  } else if (FLAGS_format == "euroc") {
    options.format = TrajectoryFormat::kEuroc;
  } else if (FLAGS_format == "kitti") {
    options.format = TrajectoryFormat::kKitti;
  } else if (FLAGS_format != "auto") {
    throw InputError("--format", "'" + FLAGS_format + "'", "auto, tum, euroc or kitti");
  }
  return options;
}

EvaluationOptions EvaluationOptionsFromFlags() {
  EvaluationOptions options;
  options.max_time_difference_ns = std::llround(1e9 * FLAGS_max_time_difference_s);
  options.relative_interval_ns = std::llround(1e9 * FLAGS_relative_interval_s);
  options.loop_segment_fraction = FLAGS_loop_segment_fraction;
  options.segment_gap_ns = std::llround(1e9 * FLAGS_segment_gap_s);
  std::string error;
  if (!options.IsValid(&error)) throw InputError("command line", error, "a valid value");
  return options;
}

// The file's name, with its folder's where all files have one name (trajectory.txt).
std::vector<std::string> LabelsFromPaths(const std::vector<std::string>& paths) {
  std::vector<std::string> labels;
  bool all_equal = paths.size() > 1;
  const auto stem = [](const std::string& path) { return std::filesystem::path(path).stem(); };
  for (const std::string& path : paths) all_equal &= stem(path) == stem(paths.front());
  for (const std::string& path : paths) {
    const auto folder = std::filesystem::absolute(path).parent_path().filename();
    labels.push_back((all_equal ? folder : stem(path)).string());
  }
  return labels;
}

std::vector<EvaluatedTrajectory> ReadEstimates(const TrajectoryReadOptions& options) {
  const std::vector<std::string> paths = SplitAtCommas(FLAGS_estimate);
  std::vector<std::string> labels = SplitAtCommas(FLAGS_label);
  if (labels.empty()) labels = LabelsFromPaths(paths);
  if (labels.size() != paths.size()) {
    throw InputError("--label",
                     std::to_string(labels.size()) + " names",
                     std::to_string(paths.size()) + ", one an estimate");
  }
  std::vector<EvaluatedTrajectory> estimates;
  for (size_t i = 0; i < paths.size(); ++i) {
    estimates.push_back({labels[i], paths[i], ReadTrajectory(paths[i], options), {}});
  }
  return estimates;
}

void PrintFailure(const EvaluatedTrajectory& entry) {
  std::cerr << "prism_eval: " << entry.path << ": found " << entry.metrics.matched_count
            << " poses that match " << FLAGS_groundtruth
            << " in time, expected at least 3 (times in seconds of one clock)" << std::endl;
}

// The keys of one estimate stand at the top where there is only one.
nlohmann::ordered_json ToJson(const std::vector<EvaluatedTrajectory>& estimates) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const EvaluatedTrajectory& entry : estimates) {
    nlohmann::ordered_json json = {{"label", entry.label}, {"estimate", entry.path}};
    json.update(MetricsToJson(entry.metrics));
    list.push_back(std::move(json));
  }
  nlohmann::ordered_json json = {{"groundtruth", FLAGS_groundtruth}};
  if (list.size() == 1) {
    json.update(list[0]);
  } else {
    json["estimates"] = std::move(list);
  }
  json["options"] = EffectiveOptions();
  return json;
}

ExitStatus Run() {
  RequireFlag("groundtruth", FLAGS_groundtruth, "a trajectory file");
  RequireFlag("estimate", FLAGS_estimate, "trajectory files");
  const TrajectoryReadOptions read_options = ReadOptionsFromFlags();
  const EvaluationOptions options = EvaluationOptionsFromFlags();
  const Trajectory groundtruth = ReadTrajectory(FLAGS_groundtruth, read_options);
  std::vector<EvaluatedTrajectory> estimates = ReadEstimates(read_options);

  bool any_done = false;
  for (EvaluatedTrajectory& entry : estimates) {
    entry.metrics = EvaluateTrajectory(groundtruth, entry.estimate, options);
    const bool done = entry.metrics.status == EvaluationStatus::kDone;
    if (!done) PrintFailure(entry);
    any_done |= done;
  }
  if (!any_done) return kExitRunFailed;

  std::cout << FormatTextTable(estimates);
  if (!FLAGS_json.empty()) WriteTextAtomically(FLAGS_json, ToJson(estimates).dump(2) + "\n");
  if (!FLAGS_csv.empty()) WriteTextAtomically(FLAGS_csv, FormatCsv(estimates));
  if (!FLAGS_latex.empty()) WriteTextAtomically(FLAGS_latex, FormatLatexRows(estimates));
  if (!FLAGS_plot_dir.empty()) {
    CreateDirectory(FLAGS_plot_dir);
    for (const auto& [name, plot] : MakeTrajectoryPlots(groundtruth, estimates, options)) {
      WritePlot((std::filesystem::path(FLAGS_plot_dir) / name).string(), plot);
    }
  }
  return kExitDone;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_eval",
       "how far estimated trajectories are from the true one",
       "--groundtruth=FILE --estimate=FILE[,FILE...] [--json=FILE] [--plot_dir=FOLDER]",
       "prism_eval --groundtruth=groundtruth.txt --estimate=out/trajectory.txt --plot_dir=out"},
      argc,
      argv,
      prism::Run);
}
