// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace prism {

struct ProgramResult {
  int exit_status = -1;  // -1: ended by a signal
  std::string output;    // stdout and stderr
};

// Runs a program of the build by a shell line, for example "prism_eval --help".
inline ProgramResult RunProgram(const std::string& command) {
  ProgramResult result;
  FILE* pipe = popen((std::string(PRISM_BIN_DIR) + "/" + command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  char buffer[4096];
  for (size_t count; (count = fread(buffer, 1, sizeof(buffer), pipe)) > 0;) {
    result.output.append(buffer, count);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.exit_status = WEXITSTATUS(status);
  return result;
}

}  // namespace prism
