// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/bench_results.h"
#include "tools/machine.h"

namespace prism {

// What the same run takes again and again, an entry of `runs` in speed.json: sequence, variant,
// command, git_hash, frames, the number of runs, and with {min, median, max} over the runs
//   frames_per_second, processor_ms_per_frame (all threads, without start and results),
//   instructions_per_frame (user mode, of the whole program; null: not to be counted here),
//   peak_resident_mib, and of each stage
//   ms_per_call (the median over its calls in a run) and ms_per_frame (its total over the frames).
// Precondition: at least one run, all done.
nlohmann::ordered_json SummarizeSpeed(const std::vector<BenchResult>& runs);

// As tables for people to read, the stage that takes most first.
std::string FormatSpeed(const nlohmann::ordered_json& summary);

}  // namespace prism
