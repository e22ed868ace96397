// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/end_signals.h"

#include <csignal>
#include <cstring>

namespace prism {
namespace {

constexpr int kEnding[] = {SIGINT, SIGTERM, SIGHUP};

// A signal handler has no other way to say anything.
volatile std::sig_atomic_t received_signal = 0;

void Note(int signal) { received_signal = signal; }

}  // namespace

EndSignals::EndSignals() {
  received_signal = 0;
  struct sigaction action = {};
  action.sa_handler = Note;
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  for (const int signal : kEnding) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    // nohup and shells' background jobs ignore some of them, and go on to.
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
  std::signal(SIGPIPE, SIG_IGN);
}

EndSignals::~EndSignals() {
  for (const int signal : kEnding) {
    struct sigaction now = {};
    sigaction(signal, nullptr, &now);
    if (now.sa_handler == Note) std::signal(signal, SIG_DFL);
  }
}

int EndSignals::received() const { return received_signal; }

std::string EndSignals::Name() const { return std::string("SIG") + sigabbrev_np(received_signal); }

}  // namespace prism
