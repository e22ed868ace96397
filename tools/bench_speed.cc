// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench_speed.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <utility>

#include <glog/logging.h>

#include "prism/base/statistics.h"
#include "prism/report/text_table.h"

namespace prism {
namespace {

using Json = nlohmann::ordered_json;
using Figure = std::function<Json(const BenchResult&)>;  // a number, or null

Json Spread(const std::vector<BenchResult>& runs, const Figure& figure) {
  std::vector<double> values;
  for (const BenchResult& run : runs) {
    const Json value = figure(run);
    if (!value.is_number()) return nullptr;
    values.push_back(value.get<double>());
  }
  return {{"min", Quantile(values, 0)},
          {"median", Quantile(values, 0.5)},
          {"max", Quantile(values, 1)}};
}

Figure OfRun(const std::string& key) {
  return [key](const BenchResult& run) { return run["run"].value(key, Json()); };
}

double FrameCount(const BenchResult& run) { return run["run"]["frame_count"].get<double>(); }

// Null in runs that had no call.
Json StageFigure(const BenchResult& run, const std::string& stage, const char* key) {
  return run["run"]["stages"].value(stage, Json::object()).value(key, Json());
}

Json SummarizeStage(const std::vector<BenchResult>& runs, const std::string& stage) {
  return {{"calls", StageFigure(runs.back(), stage, "count")},
          {"ms_per_call",
           Spread(runs, [&](const auto& run) { return StageFigure(run, stage, "median_ms"); })},
          {"ms_per_frame", Spread(runs, [&](const auto& run) {
             const Json total_ms = StageFigure(run, stage, "total_ms");
             return total_ms.is_null() ? Json() : Json(total_ms.get<double>() / FrameCount(run));
           })}};
}

// Smallest, middle and largest as cells.
std::vector<std::string> Cells(const Json& spread, const char* format) {
  if (spread.is_null()) return {"", "not available", ""};
  std::vector<std::string> cells;
  for (const auto& [name, value] : spread.items()) {
    char text[32];
    std::snprintf(text, sizeof(text), format, value.get<double>());
    cells.push_back(text);
  }
  return cells;
}

std::string FormatFigures(const Json& summary) {
  const std::tuple<const char*, const char*, const char*> figures[] = {
      {"frames_per_second", "frames a second", "%.2f"},
      {"processor_ms_per_frame", "processor ms a frame", "%.1f"},
      {"instructions_per_frame", "instructions a frame", "%.4g"},
      {"peak_resident_mib", "peak memory, MiB", "%.0f"}};
  std::vector<std::vector<std::string>> rows = {{"", "min", "median", "max"}};
  for (const auto& [key, title, format] : figures) {
    rows.push_back({title});
    for (std::string& cell : Cells(summary[key], format)) rows.back().push_back(std::move(cell));
  }
  return FormatColumns(rows);
}

std::string FormatStages(const Json& summary) {
  std::vector<std::pair<double, std::string>> stages;
  for (const auto& [name, stage] : summary["stages"].items()) {
    const Json& ms = stage["ms_per_frame"];
    stages.emplace_back(ms.is_null() ? 0 : -ms["median"].get<double>(), name);
  }
  std::sort(stages.begin(), stages.end());
  std::vector<std::vector<std::string>> rows = {
      {"stage", "calls", "ms a call: min", "median", "max", "ms a frame: min", "median", "max"}};
  for (const auto& [order, name] : stages) {
    const Json& stage = summary["stages"][name];
    rows.push_back({name, stage["calls"].dump()});
    for (const char* key : {"ms_per_call", "ms_per_frame"}) {
      for (std::string& cell : Cells(stage[key], "%.2f")) rows.back().push_back(std::move(cell));
    }
  }
  return FormatColumns(rows);
}

}  // namespace

Json SummarizeSpeed(const std::vector<BenchResult>& runs) {
  CHECK(!runs.empty());
  const BenchResult& last = runs.back();
  Json summary = {{"sequence", last["sequence"]},
                  {"variant", last["variant"]},
                  {"command", last["command"]},
                  {"git_hash", last["run"].value("git_hash", "")},
                  {"frames", last["run"]["frame_count"]},
                  {"runs", runs.size()}};
  for (const char* key : {"frames_per_second", "processor_ms_per_frame"}) {
    summary[key] = Spread(runs, OfRun(key));
  }
  summary["instructions_per_frame"] = Spread(runs, [](const BenchResult& run) {
    const Json& count = run["instructions"];
    return count.is_null() ? Json() : Json(count.get<double>() / FrameCount(run));
  });
  summary["peak_resident_mib"] = Spread(runs, OfRun("peak_resident_mib"));
  summary["stages"] = Json::object();
  for (const auto& [name, stage] : last["run"]["stages"].items()) {
    summary["stages"][name] = SummarizeStage(runs, name);
  }
  return summary;
}

std::string FormatSpeed(const Json& summary) {
  char title[256];
  std::snprintf(title,
                sizeof(title),
                "%s/%s: frames %d, runs %d, revision %s\n",
                summary["sequence"].get<std::string>().c_str(),
                summary["variant"].get<std::string>().c_str(),
                summary["frames"].get<int>(),
                summary["runs"].get<int>(),
                summary["git_hash"].get<std::string>().c_str());
  return title + FormatFigures(summary) + "\n" + FormatStages(summary);
}

}  // namespace prism
