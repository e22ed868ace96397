// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench_results.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <sstream>
#include <utility>

#include "prism/base/error.h"
#include "prism/base/statistics.h"
#include "prism/eval/metrics.h"
#include "prism/io/atomic_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/report/metrics_json.h"
#include "prism/report/text_table.h"

namespace prism {
namespace {

namespace fs = std::filesystem;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Group = std::pair<std::string, std::string>;  // sequence, variant

std::vector<Group> GroupsOf(const std::vector<BenchResult>& results) {
  std::vector<Group> groups;
  for (const BenchResult& result : results) {
    const Group group(result["sequence"], result["variant"]);
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  return groups;
}

std::vector<BenchResult> MembersOf(const Group& group, const std::vector<BenchResult>& results) {
  std::vector<BenchResult> members;
  for (const BenchResult& result : results) {
    if (result["sequence"] == group.first && result["variant"] == group.second) {
      members.push_back(result);
    }
  }
  return members;
}

std::vector<double> Collect(const std::vector<BenchResult>& results, const std::string& key) {
  std::vector<double> values;
  for (const BenchResult& result : results) values.push_back(MetricOf(result, key));
  return values;
}

std::string Format(const char* format, double value) {
  if (!std::isfinite(value)) return "inf";
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// "run" holds what run.json does; 0 where there is none (other systems).
double RunFigure(const BenchResult& result, const char* key) {
  return result.contains("run") ? result["run"].value(key, 0.0) : 0.0;
}

const char* StatusOf(const ProcessOutcome& outcome) {
  switch (outcome.end) {
    case ProcessEnd::kExited:
      return outcome.exit_status == 0 ? "done" : "failed";
    case ProcessEnd::kSignal:
      return "crashed";
    case ProcessEnd::kTimeLimit:
      return "time limit";
    case ProcessEnd::kMemoryLimit:
      return "memory limit";
    case ProcessEnd::kNotStarted:
      return "not started";
  }
  return "";
}

struct MetricColumn {
  const char* key;
  const char* title;
  const char* format;
};
constexpr MetricColumn kMetrics[] = {{"ate_rmse_m", "ATE m", "%.4f"},
                                     {"ate_rmse_sim3_m", "Sim3 m", "%.4f"},
                                     {"scale_error_percent", "scale %", "%.2f"},
                                     {"rpe_trans_rmse_m", "RPE m", "%.4f"},
                                     {"e_s", "e_s", "%.3f"},
                                     {"e_r_deg", "e_r deg", "%.2f"},
                                     {"e_align_m", "e_align m", "%.4f"}};

}  // namespace

BenchResult CollectResult(const BenchJob& job,
                          const ProcessOutcome& outcome,
                          const std::string& folder) {
  BenchResult result = {{"sequence", job.sequence},
                        {"variant", job.variant},
                        {"seed", job.seed},
                        {"command", job.arguments},
                        {"status", StatusOf(outcome)},
                        {"exit_status", outcome.exit_status},
                        {"signal", outcome.signal},
                        {"seconds", outcome.seconds},
                        {"processor_seconds", outcome.processor_seconds},
                        {"instructions", nullptr},
                        {"peak_resident_mib", outcome.peak_resident_mib}};
  if (outcome.instructions) result["instructions"] = *outcome.instructions;
  if (result["status"] != "done") return result;
  for (const char* name : {"metrics", "run"}) {
    const fs::path path = fs::path(folder) / (std::string(name) + ".json");
    if (!fs::exists(path)) continue;
    result[name] = BenchResult::parse(ReadTextFile(path.string()));
    result[name].erase("frames");
  }
  return result;
}

BenchResult EvaluateExternal(const BenchExternal& external, const std::string& groundtruth_path) {
  const TrajectoryMetrics metrics =
      EvaluateTrajectory(ReadTrajectory(groundtruth_path), ReadTrajectory(external.trajectory));
  const bool done = metrics.status == EvaluationStatus::kDone;
  return {{"sequence", external.sequence},
          {"variant", external.name},
          {"seed", 0},
          {"command", {external.trajectory}},
          {"status", done ? "done" : "failed"},
          {"metrics", MetricsToJson(metrics)}};
}

double MetricOf(const BenchResult& result, const std::string& key) {
  if (result["status"] != "done" || !result.contains("metrics")) return kInfinity;
  const auto value = result["metrics"].find(key);
  const bool is_number = value != result["metrics"].end() && value->is_number();
  return is_number ? value->get<double>() : kInfinity;
}

std::string FormatResultTable(const std::vector<BenchResult>& results) {
  std::vector<std::vector<std::string>> rows = {{"sequence/variant", "runs", "failed"}};
  for (const MetricColumn& column : kMetrics) rows[0].push_back(column.title);
  for (const char* title : {"fps", "MiB"}) rows[0].push_back(title);
  for (const Group& group : GroupsOf(results)) {
    const std::vector<BenchResult> members = MembersOf(group, results);
    const auto failed =
        std::count_if(members.begin(), members.end(), [](const BenchResult& result) {
          return result["status"] != "done";
        });
    std::vector<std::string> row = {
        group.first + "/" + group.second, std::to_string(members.size()), std::to_string(failed)};
    for (const MetricColumn& column : kMetrics) {
      row.push_back(Format(column.format, Quantile(Collect(members, column.key), 0.5)));
    }
    std::vector<double> rates;
    std::vector<double> memory_mib;
    for (const BenchResult& result : members) {
      if (!result.contains("run")) continue;
      rates.push_back(RunFigure(result, "frames_per_second"));
      memory_mib.push_back(RunFigure(result, "peak_resident_mib"));
    }
    row.push_back(rates.empty() ? "-" : Format("%.1f", Quantile(rates, 0.5)));
    row.push_back(memory_mib.empty() ? "-" : Format("%.0f", Quantile(memory_mib, 0.5)));
    rows.push_back(std::move(row));
  }
  return FormatColumns(rows);
}

std::string FormatStageTable(const std::vector<BenchResult>& results) {
  std::vector<std::string> stages;
  for (const BenchResult& result : results) {
    if (!result.contains("run")) continue;
    for (const auto& [stage, times] : result["run"]["stages"].items()) {
      if (std::find(stages.begin(), stages.end(), stage) == stages.end()) stages.push_back(stage);
    }
  }
  if (stages.empty()) return "";
  std::vector<std::vector<std::string>> rows = {{"median ms"}};
  rows[0].insert(rows[0].end(), stages.begin(), stages.end());
  for (const Group& group : GroupsOf(results)) {
    std::vector<std::string> row = {group.first + "/" + group.second};
    for (const std::string& stage : stages) {
      std::vector<double> medians_ms;
      for (const BenchResult& result : MembersOf(group, results)) {
        if (result.contains("run") && result["run"]["stages"].contains(stage)) {
          medians_ms.push_back(result["run"]["stages"][stage]["median_ms"]);
        }
      }
      row.push_back(medians_ms.empty() ? "-" : Format("%.2f", Quantile(medians_ms, 0.5)));
    }
    rows.push_back(std::move(row));
  }
  return FormatColumns(rows);
}

std::string FormatComparison(const std::vector<BenchResult>& results,
                             const std::vector<BenchResult>& baseline) {
  std::vector<std::vector<std::string>> rows = {
      {"sequence/variant", "figure", "before", "spread", "now", "spread", ""}};
  for (const Group& group : GroupsOf(results)) {
    const std::vector<BenchResult> before = MembersOf(group, baseline);
    if (before.empty()) continue;
    for (const MetricColumn& column : kMetrics) {
      const std::vector<double> a = Collect(before, column.key);
      const std::vector<double> b = Collect(MembersOf(group, results), column.key);
      const auto [a_low, a_high] = std::minmax_element(a.begin(), a.end());
      const auto [b_low, b_high] = std::minmax_element(b.begin(), b.end());
      const auto spread = [&](double low, double high) {
        return Format(column.format, low) + " to " + Format(column.format, high);
      };
      rows.push_back({group.first + "/" + group.second,
                      column.title,
                      Format(column.format, Quantile(a, 0.5)),
                      spread(*a_low, *a_high),
                      Format(column.format, Quantile(b, 0.5)),
                      spread(*b_low, *b_high),
                      *b_high < *a_low   ? "better"
                      : *b_low > *a_high ? "worse"
                                         : "same"});
    }
  }
  return FormatColumns(rows);
}

Plot CumulativePlot(const std::vector<BenchResult>& results,
                    const std::string& key,
                    const std::string& label) {
  Plot plot{"Runs with an error below x", label, "runs", {}, false, true, true};
  const double smallest = key == "e_s" || key == "d_s" ? 1 : 0;  // no error: a factor of 1
  std::vector<std::string> variants;
  double largest = smallest;
  for (const BenchResult& result : results) {
    const std::string variant = result["variant"];
    if (std::find(variants.begin(), variants.end(), variant) == variants.end()) {
      variants.push_back(variant);
    }
    const double value = MetricOf(result, key);
    if (std::isfinite(value)) largest = std::max(largest, value);
  }
  for (const std::string& variant : variants) {
    std::vector<double> values;
    for (const BenchResult& result : results) {
      if (result["variant"] == variant) values.push_back(MetricOf(result, key));
    }
    std::sort(values.begin(), values.end());
    PlotSeries series{variant, {{smallest, 0}}, false};
    double count = 0;
    for (const double value : values) {
      if (!std::isfinite(value)) break;
      series.points.push_back({value, count});
      series.points.push_back({value, ++count});
    }
    series.points.push_back({smallest + 1.05 * (largest - smallest), count});
    plot.series.push_back(std::move(series));
  }
  return plot;
}

std::vector<BenchResult> ReadResults(const std::string& path) {
  std::vector<BenchResult> results;
  std::istringstream lines(ReadTextFile(path));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    BenchResult result = BenchResult::parse(line, nullptr, false);
    if (result.is_discarded() || !result.contains("variant")) {
      throw InputError(path, "a line that is no result", "JSON lines of prism_bench");
    }
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace prism
