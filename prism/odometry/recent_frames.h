// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/map/map.h"
#include "prism/scene/frame.h"
#include "prism/tracking/frame_alignment.h"

namespace prism {

// The frames tracked on the newest keyframe. They were aligned to depths known from that keyframe
// and those before it; once the next keyframe has taught the window better ones they are aligned
// again, so that their poses are as good as the keyframes'.
class RecentFrames {
 public:
  // `map_index` as Map::AddFrame returned it.
  void Add(const LightFieldFrame& frame, const AlignmentState& state, size_t map_index);

  // Aligns all of them to the reference (the keyframe they were tracked on, with its points as they
  // are now), tells the map, and forgets them. A frame that does not fit any more keeps its pose.
  void Realign(const TrackingReference& reference,
               const NoiseModel& noise,
               const AlignmentOptions& options,
               Map* map);

  void Clear() { frames_.clear(); }

 private:
  static constexpr size_t kLevels = 2;      // finest levels kept: poses are nearly right
  static constexpr size_t kMaxFrames = 30;  // older ones keep their poses

  struct Frame {
    ImagePyramid image;  // kLevels levels
    AlignmentState state;
    size_t map_index;
  };
  std::vector<Frame> frames_;
};

}  // namespace prism
