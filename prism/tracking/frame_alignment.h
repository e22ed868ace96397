// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "prism/image/pyramid.h"
#include "prism/scene/fit_quality.h"
#include "prism/tracking/level_alignment.h"
#include "prism/tracking/point_fit.h"

namespace prism {

struct AlignmentOptions {
  LevelAlignmentOptions level;
  // Depths are unknowns with a prior on this many of the finest levels, and held on the others,
  // where freedom would only widen the basins of false minima. 0: held throughout (ablation).
  int free_depth_levels = 2;
  FitLimits possible = {4, 0.75, 0.3, 0.7, 0};  // a worse fit is no match

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
  FitQuality fit;           // of the points on level 0
  PointFits points;         // there
  double cost = 0;          // LevelCost::PerSample there, intensities^2
  std::vector<double> rho;  // inverse depths of the points as they fit, 1/m
  // Mean squared optical flow of the reference points in px of level 0, by the whole motion and by
  // its translation alone (as in DSO's keyframe decision).
  double squared_flow = 0;
  double squared_translation_flow = 0;
  int iterations = 0;
};

inline constexpr int kAllLevels = std::numeric_limits<int>::max();

// Aligns a frame to the reference, coarse to fine (LevelAlignment), from `coarsest_level` or, if
// there are fewer, the coarsest there is. `prior`: of the pose, may be null.
FrameAlignmentResult AlignFrame(const TrackingReference& reference,
                                const ImagePyramid& target,
                                const AlignmentState& initial,
                                const NoiseModel& noise,
                                const AlignmentOptions& options,
                                int coarsest_level = kAllLevels,
                                const PosePrior* prior = nullptr);

// Inverse covariance of the pose of an aligned frame (LevelAlignment::PoseInformation on level 0).
Matrix6d PoseInformation(const TrackingReference& reference,
                         const ImagePyramid& target,
                         const FrameAlignmentResult& alignment,
                         const NoiseModel& noise,
                         const AlignmentOptions& options,
                         const PosePrior* prior = nullptr);

// Aligns on the coarsest level alone, which is cheap, from each start. The distinct minima, best
// fit first; those with too little in view or beyond the limit of brightness are left out.
std::vector<AlignmentState> RankStarts(const TrackingReference& reference,
                                       const ImagePyramid& target,
                                       const std::vector<AlignmentState>& starts,
                                       const NoiseModel& noise,
                                       const AlignmentOptions& options);

// RMS distance between the projections of the reference's points into a frame at two poses
// target_from_reference, in px of level 0.
double FlowBetween(const TrackingReference& reference, const SE3& left, const SE3& right);

// Whether that is at most a pixel of the coarsest level.
bool AreOneMinimum(const TrackingReference& reference, const SE3& left, const SE3& right);

}  // namespace prism
