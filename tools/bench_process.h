// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace prism {

enum class ProcessEnd { kExited, kSignal, kTimeLimit, kMemoryLimit, kNotStarted };

struct ProcessOutcome {
  ProcessEnd end = ProcessEnd::kNotStarted;
  int exit_status = 0;                 // if it exited
  int signal = 0;                      // that ended it, if one did
  double seconds = 0;                  // wall time
  double processor_seconds = 0;        // of all its threads, user and system
  std::optional<double> instructions;  // of all its threads, in user mode; if they can be counted
  double peak_resident_mib = 0;
};

// Runs a program as a process of its own and waits for its end. stdout and stderr go to the file
// `log_path`. The process is killed once it has taken time_limit_s of wall time or has more than
// memory_limit_mib resident, and with this one.
ProcessOutcome RunProcess(const std::vector<std::string>& command,
                          const std::string& log_path,
                          double time_limit_s,
                          int memory_limit_mib);

}  // namespace prism
