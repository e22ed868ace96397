// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "prism/scene/trajectory.h"

namespace prism {

struct PlayOrderOptions {
  bool reverse = false;  // the first pass goes backwards
  int passes = 1;        // 1 or more; backwards and forwards in turn
};

// The order in which the frames of a file are played, and their times. Played times go on rising
// however the frames are played: each pass takes as long as the file, and begins where the one
// before ends. The frame at which the play turns is played once.
class PlayOrder {
 public:
  // Preconditions: at least one frame, times strictly increasing, passes >= 1.
  explicit PlayOrder(const std::vector<int64_t>& file_times_ns,
                     const PlayOrderOptions& options = {});

  int size() const { return static_cast<int>(frames_.size()); }
  // Of the n-th frame that is played: its place in `file_times_ns`, and its time as played.
  int file_index(int n) const { return frames_[n].file_index; }
  int64_t time_ns(int n) const { return frames_[n].time_ns; }

  // A trajectory in the file's times (the ground truth) as the frames are played: mirrored where
  // they are played backwards, repeated with every pass.
  Trajectory AsPlayed(const Trajectory& in_file_times) const;

  // The other way about, where there is one: with several passes a time of the file has several
  // poses, and the trajectory stays as it was played.
  Trajectory InFileTimes(const Trajectory& as_played) const;

 private:
  struct Frame {
    int file_index;
    int64_t time_ns;
  };

  int64_t duration_ns() const { return last_ns_ - first_ns_; }
  bool IsBackwards(int pass) const { return (pass % 2 == 1) != options_.reverse; }
  int64_t PlayTime(int pass, int64_t file_time_ns) const;

  PlayOrderOptions options_;
  int64_t first_ns_;  // of the file's frames
  int64_t last_ns_;
  std::vector<Frame> frames_;
};

}  // namespace prism
