// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace prism {

// Where and of what a figure of speed was measured; empty or 0 what cannot be told.
struct Machine {
  std::string processor;
  int cores = 0;  // this process may use
  double memory_gib = 0;
  std::string system;  // name and release of the kernel
  std::string compiler;
  std::string build_type;
  double load = 0;  // mean of running processes over the minute before
};

Machine ThisMachine();

nlohmann::ordered_json MachineToJson(const Machine& machine);
// Two lines for people to read.
std::string FormatMachine(const Machine& machine);

}  // namespace prism
