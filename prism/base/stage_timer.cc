// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/stage_timer.h"

#include <numeric>
#include <utility>

#include "prism/base/statistics.h"

namespace prism {

StageTimer::Scope::Scope(StageTimer* timer, std::string stage)
    : timer_(timer), stage_(std::move(stage)), start_(std::chrono::steady_clock::now()) {}

StageTimer::Scope::~Scope() {
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start_;
  timer_->Add(stage_, elapsed.count());
}

void StageTimer::Add(const std::string& stage, double milliseconds) {
  durations_ms_[stage].push_back(milliseconds);
}

std::map<std::string, StageTimer::Summary> StageTimer::Summarize() const {
  std::map<std::string, Summary> summaries;
  for (const auto& [stage, durations] : durations_ms_) {
    Summary& summary = summaries[stage];
    summary.count = static_cast<int>(durations.size());
    summary.median_ms = Quantile(durations, 0.5);
    summary.p95_ms = Quantile(durations, 0.95);
    summary.total_ms = std::accumulate(durations.begin(), durations.end(), 0.0);
  }
  return summaries;
}

}  // namespace prism
