// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/tracking/frame_alignment.h"

namespace prism {

struct TrackerOptions {
  AlignmentOptions alignment;
  // Another prediction is tried while the fit is worse than this times the typical one.
  double retry_rms_ratio = 1.5;
  // A fit worse than this times the typical one is no match, however it came about.
  double max_rms_ratio = 2.5;
  // Fits are never compared with a better one than this, intensities 0 to 255.
  double min_typical_rms = 5;
  // A frame whose root mean squared gradient is below this shows nothing; 0 to 255 a px.
  double min_rms_gradient = 0.5;
  // Rotations tried about each axis when predictions fail, rad.
  double retry_rotation = 0.03;

  bool IsValid(std::string* error) const;
};

enum class TrackingStatus { kGood, kNoTexture, kLost };

struct TrackingResult {
  TrackingStatus status = TrackingStatus::kLost;
  FrameAlignmentResult alignment;
  int attempts = 0;
};

// Tracks frames against the latest keyframe: constant-velocity prediction first, other predictions
// when the result is bad.
class Tracker {
 public:
  explicit Tracker(const TrackerOptions& options) : options_(options) {}

  // Frames that follow are aligned to this keyframe. `new_from_old_reference` carries the motion
  // model over (identity for the first keyframe).
  void SetReference(TrackingReference reference, const SE3& new_from_old_reference);

  TrackingResult Track(const ImagePyramid& target);

  // Median RMS of the last frames tracked, at least `min_typical_rms`, intensities.
  double TypicalRms() const;

  // Forgets motion and fit, for a new start; the reference stays.
  void Reset();

 private:
  std::vector<AlignmentState> Predictions() const;
  TrackingResult TryPredictions(const ImagePyramid& target) const;

  TrackerOptions options_;
  TrackingReference reference_;
  // The last two frames, relative to the current reference.
  std::vector<AlignmentState> history_;
  std::vector<double> recent_rms_;  // of the last good frames
  int misses_ = 0;                  // frames not tracked since the last good one
};

}  // namespace prism
