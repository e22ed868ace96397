// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/recent_frames.h"

#include <algorithm>

namespace prism {

void RecentFrames::Add(const LightFieldFrame& frame,
                       const AlignmentState& state,
                       size_t map_index) {
  if (frames_.size() == kMaxFrames) frames_.erase(frames_.begin());
  const size_t levels = std::min(frame.image.size(), kLevels);
  frames_.push_back(
      {ImagePyramid(frame.image.begin(), frame.image.begin() + static_cast<std::ptrdiff_t>(levels)),
       state,
       map_index});
}

void RecentFrames::Realign(const TrackingReference& reference,
                           const NoiseModel& noise,
                           const AlignmentOptions& options,
                           Map* map) {
  for (const Frame& frame : frames_) {
    const FrameAlignmentResult alignment =
        AlignFrame(reference, frame.image, frame.state, noise, options);
    if (alignment.status != AlignmentStatus::kGood) continue;
    map->MoveFrame(frame.map_index, alignment.state.target_from_reference);
  }
  frames_.clear();
}

}  // namespace prism
