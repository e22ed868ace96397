// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/play_order.h"

#include <algorithm>
#include <cstddef>

#include <glog/logging.h>

namespace prism {

PlayOrder::PlayOrder(const std::vector<int64_t>& file_times_ns, const PlayOrderOptions& options)
    : options_(options) {
  CHECK(!file_times_ns.empty());
  CHECK_GE(options.passes, 1);
  first_ns_ = file_times_ns.front();
  last_ns_ = file_times_ns.back();
  const int count = static_cast<int>(file_times_ns.size());
  for (int pass = 0; pass < options_.passes; ++pass) {
    for (int i = pass == 0 ? 0 : 1; i < count; ++i) {
      const int index = IsBackwards(pass) ? count - 1 - i : i;
      frames_.push_back({index, PlayTime(pass, file_times_ns[index])});
    }
  }
}

int64_t PlayOrder::PlayTime(int pass, int64_t file_time_ns) const {
  return first_ns_ + pass * duration_ns() +
         (IsBackwards(pass) ? last_ns_ - file_time_ns : file_time_ns - first_ns_);
}

Trajectory PlayOrder::AsPlayed(const Trajectory& in_file_times) const {
  Trajectory played;
  for (int pass = 0; pass < options_.passes; ++pass) {
    const auto begin = static_cast<std::ptrdiff_t>(played.size());
    const int64_t turn_before_ns = first_ns_ + pass * duration_ns();
    const int64_t turn_after_ns = turn_before_ns + duration_ns();
    for (const StampedPose& pose : in_file_times) {
      // Only the two ends of the whole have poses beyond the frames: elsewhere the play turns.
      const int64_t time_ns = PlayTime(pass, pose.time_ns);
      if (pass > 0 && time_ns <= turn_before_ns) continue;
      if (pass + 1 < options_.passes && time_ns > turn_after_ns) continue;
      played.push_back({time_ns, pose.world_from_cam});
    }
    if (IsBackwards(pass)) std::reverse(played.begin() + begin, played.end());
  }
  return played;
}

Trajectory PlayOrder::InFileTimes(const Trajectory& as_played) const {
  Trajectory in_file_times = as_played;
  if (options_.passes > 1 || !options_.reverse) return in_file_times;
  for (StampedPose& pose : in_file_times) pose.time_ns = first_ns_ + last_ns_ - pose.time_ns;
  std::reverse(in_file_times.begin(), in_file_times.end());
  return in_file_times;
}

}  // namespace prism
