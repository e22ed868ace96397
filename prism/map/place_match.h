// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prism/points/selection.h"
#include "prism/scene/frame.h"
#include "prism/scene/noise_model.h"
#include "prism/scene/place.h"
#include "prism/tracking/frame_alignment.h"

namespace prism {

struct PlaceMatchOptions {
  int query_points = 800;  // of a frame, its own depths, that known images are aligned to
  int min_matches = 12;    // of features, to look at a place at all
  int max_candidates = 6;  // places looked at, most matches first
  int min_inliers = 8;     // features that agree on a pose
  // Of the alignment of the frame to the place, and back, which stands on depths of a single frame.
  // What repeats (bricks, windows) matches but for whole areas: a seventh of the image and more
  // there and a quarter back (the facade of the simulator), up to a sixteenth and a twelfth where
  // it is one place (rendered rooms, a real kitchen).
  FitLimits there = {1.8, 0.2, 0.35, 0.5, 0.75, 0.08};
  FitLimits back = {2, 0.28, 0.35, 0.5, 0, 0.1};
  // RMS, fraction of the image width: alignments there and back that differ by more are no match.
  double max_disagreement = 0.003;

  bool IsValid(std::string* error) const;
};

// A frame to be found among places. What is passed must outlive it.
struct PlaceQuery {
  const LightFieldFrame& frame;
  Place place;                  // its features and median depth; neither image nor points
  TrackingReference reference;  // with the depths it measures itself
};
PlaceQuery MakePlaceQuery(const PlenopticCamera& camera,
                          const LightFieldFrame& frame,
                          const PointSelectionOptions& selection,
                          const PlaceMatchOptions& options);

struct PlaceMatch {
  int keyframe_id = 0;  // of the place
  SE3 query_from_known;
  Matrix6d information = Matrix6d::Zero();  // of it, tangent on its left
  int feature_inliers = 0;
};

// Whether the query, started at a pose, shows what the place does: it aligns to the place and the
// place to it, both well and with the depths measured in the query, and the two alignments are each
// other's inverse. `depth_offset`: of the query's 1/v.
std::optional<PlaceMatch> VerifyMatch(const PlenopticCamera& camera,
                                      const Place& place,
                                      const PlaceQuery& query,
                                      const SE3& start,
                                      const NoiseModel& noise,
                                      double depth_offset,
                                      const AlignmentOptions& alignment,
                                      const PlaceMatchOptions& options);

// The places, of those given, that show what the query shows: features agree on a pose, and from
// there VerifyMatch holds. Best first (most features).
std::vector<PlaceMatch> FindMatches(const PlenopticCamera& camera,
                                    const std::vector<const Place*>& places,
                                    const PlaceQuery& query,
                                    const NoiseModel& noise,
                                    double depth_offset,
                                    const AlignmentOptions& alignment,
                                    const PlaceMatchOptions& options);

}  // namespace prism
