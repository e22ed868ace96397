// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace prism {

// While one of these is there, SIGINT, SIGTERM and SIGHUP are noted instead of ending the program,
// the first time: the same signal once more ends it. A closed pipe on stdout (SIGPIPE) ends
// nothing. There is one at a time.
class EndSignals {
 public:
  EndSignals();
  ~EndSignals();
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;

  // 0: none so far.
  int received() const;
  std::string Name() const;  // "SIGINT"

  // As a shell says that a program was ended by the signal.
  int ExitStatus() const { return 128 + received(); }
};

}  // namespace prism
