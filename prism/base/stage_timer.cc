// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/stage_timer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prism {
namespace {

constexpr double kShortest_ms = 1e-4;  // all that is shorter is one class
constexpr double kClassWidth = 0.01;   // of the logarithm

int ClassOf(double milliseconds) {
  return static_cast<int>(std::log(std::max(milliseconds, kShortest_ms) / kShortest_ms) /
                          kClassWidth);
}

}  // namespace

StageTimer::Scope::Scope(StageTimer* timer, std::string stage)
    : timer_(timer), stage_(std::move(stage)), start_(std::chrono::steady_clock::now()) {}

StageTimer::Scope::~Scope() {
  if (timer_ == nullptr) return;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start_;
  timer_->Add(stage_, elapsed.count());
}

void StageTimer::Add(const std::string& name, double milliseconds) {
  Stage& stage = stages_[name];
  for (Durations* durations : {&stage.all, &stage.classes[ClassOf(milliseconds)]}) {
    ++durations->count;
    durations->total_ms += milliseconds;
  }
}

// Mean of the class that holds the nearest rank.
double StageTimer::QuantileOf(const Stage& stage, double q) {
  int left = std::max(1, static_cast<int>(std::ceil(q * stage.all.count)));
  auto members = stage.classes.begin();
  while ((left -= members->second.count) > 0) ++members;
  return members->second.total_ms / members->second.count;
}

std::map<std::string, StageTimer::Summary> StageTimer::Summarize() const {
  std::map<std::string, Summary> summaries;
  for (const auto& [name, stage] : stages_) {
    summaries[name] = {
        stage.all.count, QuantileOf(stage, 0.5), QuantileOf(stage, 0.95), stage.all.total_ms};
  }
  return summaries;
}

std::map<std::string, double> StageTimer::Totals() const {
  std::map<std::string, double> totals_ms;
  for (const auto& [name, stage] : stages_) totals_ms[name] = stage.all.total_ms;
  return totals_ms;
}

std::map<std::string, double> TakeNewTimes(const StageTimer& timer,
                                           std::map<std::string, double>* totals) {
  std::map<std::string, double> times_ms;
  for (const auto& [stage, total_ms] : timer.Totals()) {
    double& taken_ms = (*totals)[stage];
    if (total_ms > taken_ms) times_ms[stage] = total_ms - taken_ms;
    taken_ms = total_ms;
  }
  return times_ms;
}

}  // namespace prism
