// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prism/map/map.h"
#include "prism/map/place_match.h"

namespace prism {

struct JoiningOptions {
  bool join = true;  // false: a segment that starts after a loss stays on its own (ablation)
  bool close_loops = false;  // places are looked for all the time, for Map::CloseLoops
  PlaceMatchOptions match;
  int max_places = 200;
  // Keyframes whose matches have to agree on where a segment stands before it is joined: two views
  // that look alike rarely do so twice in the same way.
  int min_agreeing = 2;
  // What they may differ by, RMS flow, fraction of the image width: so much, and so much of the
  // flow between the two keyframes, as the segment may be wrong by itself (a start before a blank
  // wall), but no more than four times so much in all.
  double max_flow = 0.006;
  double max_flow_of_motion = 0.15;
  // After a join, that are looked for in the rest of the piece as well: the first keyframes of a
  // segment, which join it, know its direction least (FitSegment).
  int settling_keyframes = 12;
  // Loops: the place is this many keyframes back at least, and stands where it was expected to
  // within this fraction of the path between, and this much.
  int min_loop_keyframes = 5;
  double max_loop_drift = 0.1;
  double max_loop_offset_m = 0.02;
  double max_loop_rotation = 0.15;  // rad

  bool IsValid(std::string* error) const;
};

// Where one match puts a segment.
struct SegmentPlacement {
  int onto_piece = 0;
  SE3 world_from_segment;
  SE3 cam_from_segment;  // of the keyframe that says so
};

// Collects what the keyframes of a segment say of where it stands.
class SegmentJoiner {
 public:
  // The next segment, of which nothing is known.
  void Reset() { *this = {}; }

  // What the matches of one keyframe say; `reference` is that keyframe with its depths, for
  // distances in px. The placement, their mean, once enough keyframes agree on it and more than
  // twice as many as contradict it. A keyframe whose own matches disagree contradicts all.
  std::optional<SegmentPlacement> Observe(const JoiningOptions& options,
                                          const std::vector<SegmentPlacement>& matches,
                                          const TrackingReference& reference);

 private:
  static constexpr size_t kRemembered =
      5;  // a segment that drifts contradicts what it said long ago

  // Of the last keyframes that matched anything; nothing: their own matches disagreed.
  std::vector<std::optional<SegmentPlacement>> placements_;
};

// A keyframe of a joined segment, found in what the rest of its piece shows.
struct Sighting {
  int keyframe_id = 0;
  SE3 cam_from_world;
  double depth = 1;  // median of what it shows, m
};

// world_from_segment for which keyframes and what lies before them, at `depth`, are nearest to
// where they were found; those that are off by more than three times the median are left out.
// Nothing for fewer than three.
std::optional<SE3> FitSegment(const Map& map, int segment, const std::vector<Sighting>& sightings);

// Whether a match within a piece of the map is one that the drift since allows. `keyframe_id`: that
// of the query.
bool IsPlausibleLoop(const JoiningOptions& options,
                     const Map& map,
                     const PlaceMatch& match,
                     int keyframe_id);

// Where a match puts the segment in which the query has a pose.
SegmentPlacement PlaceSegment(const Map& map, const PlaceMatch& match, const SE3& cam_from_segment);

}  // namespace prism
