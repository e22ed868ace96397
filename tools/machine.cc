// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/machine.h"

#include <stdlib.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <thread>

namespace prism {
namespace {

std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "";
}

std::string SystemName() {
  utsname names;
  if (uname(&names) != 0) return "";
  return std::string(names.sysname) + " " + names.release;
}

}  // namespace

Machine ThisMachine() {
  Machine machine;
  machine.processor = ProcessorName();
  machine.cores = static_cast<int>(std::thread::hardware_concurrency());
  machine.memory_gib = static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 30);
  machine.system = SystemName();
#ifdef __clang__
  machine.compiler = __VERSION__;  // has the name
#else
  machine.compiler = "GCC " __VERSION__;
#endif
  machine.build_type = PRISM_BUILD_TYPE;
  if (getloadavg(&machine.load, 1) != 1) machine.load = 0;
  return machine;
}

nlohmann::ordered_json MachineToJson(const Machine& machine) {
  return {{"processor", machine.processor},
          {"cores", machine.cores},
          {"memory_gib", machine.memory_gib},
          {"system", machine.system},
          {"compiler", machine.compiler},
          {"build_type", machine.build_type},
          {"load_before", machine.load}};
}

std::string FormatMachine(const Machine& machine) {
  char text[256];
  std::snprintf(text,
                sizeof(text),
                "%s, %d cores, %.1f GiB, %s, load %.1f before\n%s, %s\n",
                machine.processor.c_str(),
                machine.cores,
                machine.memory_gib,
                machine.system.c_str(),
                machine.load,
                machine.compiler.c_str(),
                machine.build_type.c_str());
  return text;
}

}  // namespace prism
