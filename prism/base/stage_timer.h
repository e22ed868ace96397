// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace prism {

// Wall-clock durations per named stage. What is kept of a stage does not grow with the calls:
// durations are gathered in classes 1 % wide.
class StageTimer {
 public:
  // Adds the time from its construction to its destruction to a stage; without a timer nothing.
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
    double median_ms = 0;  // to 1 %, as p95_ms
    double p95_ms = 0;
    double total_ms = 0;
  };

  void Add(const std::string& stage, double milliseconds);
  std::map<std::string, Summary> Summarize() const;
  // Of every stage so far, in milliseconds.
  std::map<std::string, double> Totals() const;

 private:
  struct Durations {
    int count = 0;
    double total_ms = 0;
  };
  struct Stage {
    Durations all;
    std::map<int, Durations> classes;  // by the logarithm of the duration
  };

  static double QuantileOf(const Stage& stage, double q);

  std::map<std::string, Stage> stages_;
};

// Milliseconds that each stage of `timer` has got since the last call with the same `totals`
// (empty: all), without the stages that have got none.
std::map<std::string, double> TakeNewTimes(const StageTimer& timer,
                                           std::map<std::string, double>* totals);

}  // namespace prism
