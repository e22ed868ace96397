// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "prism/report/plot.h"
#include "tools/bench_process.h"
#include "tools/bench_suite.h"

namespace prism {

// One run: a line of results.jsonl. Holds sequence, variant, seed, command, status ("done",
// "failed", "crashed", "time limit", "memory limit", "not started"), seconds, processor_seconds,
// instructions (null: cannot be counted here), peak_resident_mib and, of a run that is done,
// metrics (metrics.json) and run (run.json without its frames).
using BenchResult = nlohmann::ordered_json;

// Reads what a finished process left in `folder`.
BenchResult CollectResult(const BenchJob& job,
                          const ProcessOutcome& outcome,
                          const std::string& folder);

// Evaluates a trajectory of another system like a run of its own, with the name as the variant.
BenchResult EvaluateExternal(const BenchExternal& external, const std::string& groundtruth_path);

// Of result["metrics"][key]: infinity if the run failed or has no such figure.
double MetricOf(const BenchResult& result, const std::string& key);

// A row for each sequence and variant, in order of appearance: runs, failures, medians over the
// runs (a failure is infinite) of ATE, scale error, e_s, e_r, e_align, and of rate and memory.
std::string FormatResultTable(const std::vector<BenchResult>& results);
// A row for each sequence and variant: medians over the runs of each stage's median (ms).
std::string FormatStageTable(const std::vector<BenchResult>& results);
// Medians beside those of another suite with the spread (smallest to largest) over the runs;
// "better" or "worse" where the two spreads do not overlap.
std::string FormatComparison(const std::vector<BenchResult>& results,
                             const std::vector<BenchResult>& baseline);

// Number of runs with an error below x, a line a variant; `key` as in metrics.json.
Plot CumulativePlot(const std::vector<BenchResult>& results,
                    const std::string& key,
                    const std::string& label);

// results.jsonl of a folder. Throws InputError if it cannot be read.
std::vector<BenchResult> ReadResults(const std::string& path);

}  // namespace prism
