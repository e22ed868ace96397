// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prism/camera/plenoptic_camera.h"
#include "prism/camera/projection.h"
#include "prism/factors/pixel_residual.h"
#include "prism/geometry/se3.h"
#include "prism/image/pyramid.h"
#include "prism/scene/fit_quality.h"
#include "prism/scene/noise_model.h"

namespace prism {

// A point a new frame is aligned to: a pixel of the reference keyframe with its inverse depth.
struct ReferencePoint {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // focused px of level 0, in the reference keyframe
  double rho = 0;                                // 1/m, there
};

// The reference keyframe as the tracker sees it; built once a keyframe by MakeTrackingReference.
struct TrackingReference {
  struct Sample {
    ReferencePixel pixel;
    double rho;
  };
  std::vector<PlenopticProjection> cameras;  // one a level
  std::vector<std::vector<Sample>> levels;   // level 0 finest
  bool empty() const { return levels.empty() || levels[0].empty(); }
};

struct AlignmentOptions {
  int max_iterations = 30;  // per level
  // Of a pixel's residual in NoiseModel::FitSigma(): where Huber's norm becomes linear (1.345 costs
  // 5 % of efficiency on Gaussian residuals), and beyond which it says nothing about the pose.
  double huber = 1.345;
  double outlier = 4.5;
  bool robust = true;             // false: no Huber norm (ablation)
  bool affine_brightness = true;  // false: brightness is held (ablation)
  FitLimits possible;             // a worse fit is no match

  bool IsValid(std::string* error) const;
};

enum class AlignmentStatus {
  kGood,
  kTooFewPoints,  // the reference has none
  kDiverged,      // no finite solution
  kBadFit,        // beyond AlignmentOptions::possible
};

struct AlignmentState {
  SE3 target_from_reference;
  double a = 0;  // relative brightness: I_target = e^a I_reference + b
  double b = 0;
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

// Samples the reference image at the points on every level: the pattern of DSO on level 0, the
// pixel alone on coarser levels. `image` is the reference keyframe's pyramid.
TrackingReference MakeTrackingReference(const PlenopticCamera& camera,
                                        const ImagePyramid& image,
                                        const std::vector<ReferencePoint>& points);

// Aligns a frame to the reference over pose and affine brightness, coarse to fine, by
// Levenberg-Marquardt on the photometric residual Eq. (20) with fixed depths; robust (Huber).
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
