// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/metrics_table.h"

#include <cstdio>
#include <optional>

#include "prism/report/text_table.h"

namespace prism {
namespace {

using Value = std::optional<double>;

struct Column {
  const char* title;
  const char* latex_title;
  const char* csv_name;
  const char* format;  // of a double
  Value (*value)(const TrajectoryMetrics&);
};

bool IsDone(const TrajectoryMetrics& m) { return m.status == EvaluationStatus::kDone; }

const Column kColumns[] = {
    {"matched",
     "matched",
     "matched_count",
     "%.0f",
     [](const TrajectoryMetrics& m) { return Value(m.matched_count); }},
    {"cover %",
     "cover (\\%)",
     "coverage_percent",
     "%.1f",
     [](const TrajectoryMetrics& m) { return Value(m.coverage_percent); }},
    {"ATE m",
     "ATE (m)",
     "ate_rmse_m",
     "%.4f",
     [](const TrajectoryMetrics& m) { return IsDone(m) ? Value(m.ate_rmse_m) : Value(); }},
    {"Sim3 m",
     "ATE Sim3 (m)",
     "ate_rmse_sim3_m",
     "%.4f",
     [](const TrajectoryMetrics& m) { return m.sim3 ? Value(m.sim3->ate_rmse_m) : Value(); }},
    {"scale",
     "scale",
     "scale",
     "%.4f",
     [](const TrajectoryMetrics& m) { return m.sim3 ? Value(m.sim3->scale) : Value(); }},
    {"scale %",
     "scale error (\\%)",
     "scale_error_percent",
     "%.2f",
     [](const TrajectoryMetrics& m) {
       return m.sim3 ? Value(m.sim3->scale_error_percent) : Value();
     }},
    {"RPE m",
     "RPE (m)",
     "rpe_trans_rmse_m",
     "%.4f",
     [](const TrajectoryMetrics& m) {
       return m.relative_over_time ? Value(m.relative_over_time->trans_rmse_m) : Value();
     }},
    {"RPE deg",
     "RPE (deg)",
     "rpe_rot_rmse_deg",
     "%.3f",
     [](const TrajectoryMetrics& m) {
       return m.relative_over_time ? Value(m.relative_over_time->rot_rmse_deg) : Value();
     }},
    {"e_s",
     "$e_s$",
     "e_s",
     "%.4f",
     [](const TrajectoryMetrics& m) { return m.loop ? Value(m.loop->e_s) : Value(); }},
    {"e_r deg",
     "$e_r$ (deg)",
     "e_r_deg",
     "%.3f",
     [](const TrajectoryMetrics& m) { return m.loop ? Value(m.loop->e_r_deg) : Value(); }},
    {"e_align m",
     "$e_{align}$ (m)",
     "e_align_m",
     "%.4f",
     [](const TrajectoryMetrics& m) { return m.loop ? Value(m.loop->e_align_m) : Value(); }},
};

std::string Format(const char* format, Value value, const std::string& missing) {
  if (!value) return missing;
  char text[64];
  std::snprintf(text, sizeof(text), format, *value);
  return text;
}

using Row = std::vector<std::string>;

// A segment as a row of its own: only what is known of a segment is set.
Row SegmentRow(const SegmentMetrics& segment, size_t number) {
  Row row = {"  segment " + std::to_string(number), std::to_string(segment.matched_count), ""};
  row.push_back(Format("%.4f", segment.ate_rmse_m, "-"));
  row.push_back("");
  row.push_back(Format("%.4f", segment.scale, "-"));
  row.resize(std::size(kColumns) + 1);
  return row;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string LatexText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string("&%$#_{}").find(c) != std::string::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

}  // namespace

std::string FormatTextTable(const std::vector<EvaluatedTrajectory>& estimates) {
  std::vector<Row> rows(1, Row{"estimate"});
  for (const Column& column : kColumns) rows[0].push_back(column.title);
  for (const EvaluatedTrajectory& entry : estimates) {
    Row row = {entry.label};
    for (const Column& column : kColumns) {
      row.push_back(Format(column.format, column.value(entry.metrics), "-"));
    }
    rows.push_back(std::move(row));
    const auto& segments = entry.metrics.segments;
    for (size_t i = 0; segments.size() > 1 && i < segments.size(); ++i) {
      rows.push_back(SegmentRow(segments[i], i + 1));
    }
  }
  return FormatColumns(rows);
}

std::string FormatCsv(const std::vector<EvaluatedTrajectory>& estimates) {
  std::string text = "label,path";
  for (const Column& column : kColumns) text += std::string(",") + column.csv_name;
  text += '\n';
  for (const EvaluatedTrajectory& entry : estimates) {
    text += CsvField(entry.label) + "," + CsvField(entry.path);
    for (const Column& column : kColumns) {
      text += "," + Format("%.9g", column.value(entry.metrics), "");
    }
    text += '\n';
  }
  return text;
}

std::string FormatLatexRows(const std::vector<EvaluatedTrajectory>& estimates) {
  std::string text = "estimate";
  for (const Column& column : kColumns) text += std::string(" & ") + column.latex_title;
  text += " \\\\\n";
  for (const EvaluatedTrajectory& entry : estimates) {
    text += LatexText(entry.label);
    for (const Column& column : kColumns) {
      text += " & " + Format(column.format, column.value(entry.metrics), "--");
    }
    text += " \\\\\n";
  }
  return text;
}

}  // namespace prism
