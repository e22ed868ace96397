// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace prism {

enum ExitStatus { kExitDone = 0, kExitRunFailed = 1, kExitBadInput = 2 };

struct ToolDescription {
  std::string name;
  std::string summary;  // one sentence
  std::string usage;    // one line of arguments
  std::string example;  // one command that works
};

// Parses flags, prints the effective options, runs `run` and turns an InputError into one line on
// stderr and exit status 2; an OptionError is told as one of the flag of that name. --help prints
// summary, usage, example and the program's own flags, --version `NAME VERSION (GIT REVISION)`.
int RunTool(const ToolDescription& description,
            int argc,
            char** argv,
            const std::function<ExitStatus()>& run);

// What the program was built from, as `git describe` says it; "unknown" without git.
std::string GitRevision();

// Name and value of every flag of this program (not of glog and gflags).
std::map<std::string, std::string> EffectiveOptions();

// Throws InputError("--name", "nothing", expected) if a required flag is empty.
void RequireFlag(const std::string& name, const std::string& value, const std::string& expected);

// Throws InputError("--name", value, "MIN to MAX") unless the value is a number between them.
void RequireInRange(const std::string& name, double value, double min, double max);

// The parts of a list flag; empty ones are left out.
std::vector<std::string> SplitAtCommas(const std::string& text);

}  // namespace prism
