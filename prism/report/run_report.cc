// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/run_report.h"

#include <algorithm>

#include "prism/io/atomic_file.h"
#include "prism/report/report_page.h"

namespace prism {
namespace {

constexpr size_t kMaxProblems = 48;

}  // namespace

std::vector<std::string> FindProblems(const std::vector<ReportFrame>& frames) {
  std::vector<std::string> problems;
  int segments = 0, joined = 0, held = 0, not_named = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    joined += frames[i].is_joined;
    held += frames[i].is_held;
    if (frames[i].is_tracked) {
      segments = std::max(segments, frames[i].segment + 1);
      continue;
    }
    size_t last = i;
    while (last + 1 < frames.size() && !frames[last + 1].is_tracked &&
           frames[last + 1].status == frames[i].status) {
      ++last;
    }
    const std::string which = last == i
                                  ? "frame " + std::to_string(i)
                                  : "frames " + std::to_string(i) + " to " + std::to_string(last);
    if (problems.size() < kMaxProblems - 1) {
      problems.push_back(which + " not tracked (" + frames[i].status + ")");
    } else {
      not_named += static_cast<int>(last - i) + 1;
    }
    i = last;
  }
  if (not_named > 0) {
    problems.push_back(std::to_string(not_named) + " more frames not tracked");
  }
  if (held > 0) {
    problems.push_back(std::to_string(held) +
                       " frames show little and are held by the motion before them");
  }
  if (segments > 1) {
    std::string text = "the trajectory has " + std::to_string(segments) + " segments";
    if (joined > 0) text += ", " + std::to_string(joined) + " of them found again and joined";
    problems.push_back(text);
  }
  return problems;
}

std::string FormatReport(const RunReport& report, bool live) {
  nlohmann::json json = ReportToJson(report);
  json["live"] = live;
  return PageWithData(kReportPage, json);
}

void WriteReport(const std::string& path, const RunReport& report) {
  WriteTextAtomically(path, FormatReport(report));
}

}  // namespace prism
