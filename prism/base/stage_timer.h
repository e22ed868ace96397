// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace prism {

// Wall-clock durations per named stage, one entry a call.
class StageTimer {
 public:
  // Adds the time from its construction to its destruction to a stage.
  class Scope {
   public:
    Scope(StageTimer* timer, std::string stage);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    StageTimer* timer_;
    std::string stage_;
    std::chrono::steady_clock::time_point start_;
  };

  struct Summary {
    int count = 0;
    double median_ms = 0;
    double p95_ms = 0;
    double total_ms = 0;
  };

  void Add(const std::string& stage, double milliseconds);
  std::map<std::string, Summary> Summarize() const;
  // All durations of all stages in milliseconds, in order of the calls.
  const std::map<std::string, std::vector<double>>& durations_ms() const { return durations_ms_; }

 private:
  std::map<std::string, std::vector<double>> durations_ms_;
};

}  // namespace prism
