// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench_process.h"

#include <fcntl.h>
#include <linux/perf_event.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
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

// Instructions that children forked after this carry out in user mode from their exec on. Counts
// nothing where the machine has no counter, as virtual ones often, or the kernel does not allow it.
class ChildInstructions {
 public:
  ChildInstructions() {
    perf_event_attr attributes{};
    attributes.size = sizeof(attributes);
    attributes.type = PERF_TYPE_HARDWARE;
    attributes.config = PERF_COUNT_HW_INSTRUCTIONS;
    attributes.disabled = 1;  // in this process, for good
    attributes.enable_on_exec = 1;
    attributes.inherit = 1;
    attributes.exclude_kernel = 1;
    attributes.exclude_hv = 1;
    file_ = static_cast<int>(
        syscall(SYS_perf_event_open, &attributes, 0, -1, -1, PERF_FLAG_FD_CLOEXEC));
  }
  ~ChildInstructions() {
    if (file_ >= 0) close(file_);
  }
  ChildInstructions(const ChildInstructions&) = delete;
  ChildInstructions& operator=(const ChildInstructions&) = delete;

  // Of the children that have ended.
  std::optional<double> Read() const {
    uint64_t count = 0;
    if (file_ < 0 || read(file_, &count, sizeof(count)) != sizeof(count) || count == 0) {
      return std::nullopt;
    }
    return static_cast<double>(count);
  }

 private:
  int file_ = -1;
};

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

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
  const ChildInstructions instructions;
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
  outcome.processor_seconds = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  outcome.instructions = instructions.Read();
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
