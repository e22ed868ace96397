// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/unreadable_frames.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include "prism/base/error.h"

namespace prism {
namespace {

constexpr size_t kShown = 5;

}  // namespace

UnreadableFrames::UnreadableFrames(std::string sequence, int frame_count)
    : sequence_(std::move(sequence)), frame_count_(frame_count) {}

void UnreadableFrames::Add(int number, const UnreadableFrame& frame) {
  if (reasons_.empty()) first_ = frame.what();
  reasons_[frame.time_ns] = frame.what();
  const int count = static_cast<int>(reasons_.size());
  const auto fail = [&](const std::string& which, const std::string& expected) {
    throw InputError(sequence_, which + " unreadable (" + first_ + ")", expected);
  };
  if (count == number + 1 && count >= std::min(kMaxAtStart, frame_count_)) {
    fail("the first " + std::to_string(count) + " frames", "images at the start");
  }
  if (count > kMaxShare * frame_count_) {
    fail(std::to_string(count) + " of " + std::to_string(frame_count_) + " frames",
         "at most half of them");
  }
  if (reasons_.size() <= kShown) {
    std::cout << "\nframe " << number << " unreadable: " << frame.what() << std::endl;
  }
}

}  // namespace prism
