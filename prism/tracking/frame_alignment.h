// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/image/pyramid.h"
#include "prism/scene/fit_quality.h"
#include "prism/tracking/level_alignment.h"

namespace prism {

struct AlignmentOptions {
  LevelAlignmentOptions level;
  // Depths are unknowns with a prior on this many of the finest levels, and held on the others,
  // where freedom would only widen the basins of false minima. 0: held throughout (ablation).
  int free_depth_levels = 2;
  FitLimits possible;  // a worse fit is no match

  bool IsValid(std::string* error) const;
};

enum class AlignmentStatus {
  kGood,
  kTooFewPoints,  // the reference has none
  kDiverged,      // no finite solution
  kBadFit,        // beyond AlignmentOptions::possible
};

struct FrameAlignmentResult {
  AlignmentStatus status = AlignmentStatus::kDiverged;
  AlignmentState state;
  FitQuality fit;   // of the samples on level 0
  double rms = 0;   // of the inliers on level 0, intensities
  int inliers = 0;  // samples on level 0
  // Mean squared optical flow of the reference points in px of level 0, by the whole motion and by
  // its translation alone (as in DSO's keyframe decision).
  double squared_flow = 0;
  double squared_translation_flow = 0;
  int iterations = 0;
};

// Aligns a frame to the reference, coarse to fine (LevelAlignment).
FrameAlignmentResult AlignFrame(const TrackingReference& reference,
                                const ImagePyramid& target,
                                const AlignmentState& initial,
                                const NoiseModel& noise,
                                const AlignmentOptions& options);

// Aligns on the coarsest level alone, which is cheap, from each start. The distinct minima, best
// fit first; those with too little in view or beyond the limit of brightness are left out.
std::vector<AlignmentState> RankStarts(const TrackingReference& reference,
                                       const ImagePyramid& target,
                                       const std::vector<AlignmentState>& starts,
                                       const NoiseModel& noise,
                                       const AlignmentOptions& options);

// Whether the points of the reference are a pixel of the coarsest level apart, or less, between two
// poses.
bool AreOneMinimum(const TrackingReference& reference, const SE3& left, const SE3& right);

}  // namespace prism
