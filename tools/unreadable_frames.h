// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "prism/run/sequence.h"

namespace prism {

// The frames of a run that could not be read, up to the point where the sequence is at fault.
class UnreadableFrames {
 public:
  // As many at the start, or more than this share of all, are not bad luck.
  static constexpr int kMaxAtStart = 10;
  static constexpr double kMaxShare = 0.5;

  // `frame_count`: that are played.
  UnreadableFrames(std::string sequence, int frame_count);

  // Says so on the console, of the first few. `number`: of the frame as played. Throws InputError
  // where there are too many.
  void Add(int number, const UnreadableFrame& frame);

  // By their times as played.
  const std::map<int64_t, std::string>& reasons() const { return reasons_; }

 private:
  std::string sequence_;
  int frame_count_;
  std::string first_;
  std::map<int64_t, std::string> reasons_;
};

}  // namespace prism
