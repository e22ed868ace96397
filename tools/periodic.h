// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <utility>

namespace prism {

// Something that is done now and again while something else goes on: every five seconds, or as
// seldom as it takes for a twentieth of the time at most.
class Periodic {
 public:
  explicit Periodic(std::function<void()> action) : action_(std::move(action)) {}

  // Does it if it is time.
  void Tick() {
    const Clock::time_point begin = Clock::now();
    if (begin < next_) return;
    action_();
    const Clock::time_point end = Clock::now();
    next_ = end + std::max<Clock::duration>(std::chrono::seconds(5), 19 * (end - begin));
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::function<void()> action_;
  Clock::time_point next_ = Clock::now() + std::chrono::seconds(5);
};

}  // namespace prism
