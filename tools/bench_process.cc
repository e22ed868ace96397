// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include <glog/logging.h>

namespace prism {
namespace {

constexpr auto kPollInterval = std::chrono::milliseconds(20);
constexpr int kNotStartedStatus = 127;

double ResidentMib(pid_t process) {
  std::ifstream statm("/proc/" + std::to_string(process) + "/statm");
  double total_pages = 0;
  double resident_pages = 0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

// In the child: never returns. Only calls that are safe after a fork.
[[noreturn]] void Execute(std::vector<char*>* arguments, const char* log_path) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int log = open(log_path, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (log >= 0) {
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
  }
  execv((*arguments)[0], arguments->data());
  _exit(kNotStartedStatus);
}

}  // namespace

ProcessOutcome RunProcess(const std::vector<std::string>& command,
                          const std::string& log_path,
                          double time_limit_s,
                          int memory_limit_mib) {
  CHECK(!command.empty());
  std::vector<char*> arguments;
  for (const std::string& argument : command)
    arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);

  ProcessOutcome outcome;
  const auto start = std::chrono::steady_clock::now();
  const pid_t process = fork();
  if (process < 0) return outcome;
  if (process == 0) Execute(&arguments, log_path.c_str());

  int status = 0;
  rusage usage{};
  outcome.end = ProcessEnd::kExited;
  while (wait4(process, &status, WNOHANG, &usage) == 0) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (outcome.end == ProcessEnd::kExited) {
      if (elapsed.count() > time_limit_s) outcome.end = ProcessEnd::kTimeLimit;
      if (ResidentMib(process) > memory_limit_mib) outcome.end = ProcessEnd::kMemoryLimit;
      if (outcome.end != ProcessEnd::kExited) kill(process, SIGKILL);
    }
    std::this_thread::sleep_for(kPollInterval);
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.peak_resident_mib = static_cast<double>(usage.ru_maxrss) / 1024;
  if (WIFEXITED(status)) outcome.exit_status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) {
    outcome.signal = WTERMSIG(status);
    if (outcome.end == ProcessEnd::kExited) outcome.end = ProcessEnd::kSignal;
  }
  if (outcome.end == ProcessEnd::kExited && outcome.exit_status == kNotStartedStatus) {
    outcome.end = ProcessEnd::kNotStarted;
  }
  return outcome;
}

}  // namespace prism
