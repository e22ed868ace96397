// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/tracking/frame_alignment.h"

namespace prism {

struct TrackerOptions {
  AlignmentOptions alignment;
  // Other starts are tried when the fit is worse than this times the typical one.
  double retry_rms_ratio = 1.5;
  // A fit worse than this times the typical one is no match, however it came about.
  double max_rms_ratio = 2.5;
  // Other starts are tried, too, when more of the samples than this are outliers.
  double max_outlier_fraction = 0.15;
  // While no RMS is typical yet, a fit with more outliers than this is no match.
  double max_start_outlier_fraction = 0.25;
  // Fits are never compared with a better one than this, intensities 0 to 255.
  double min_typical_rms = 5;
  // A frame whose root mean squared gradient is below this shows nothing; 0 to 255 a px.
  double min_rms_gradient = 0.5;
  // Starts tried then, beside those of the motion model: turns that shift the image by up to
  // `retry_steps` of `retry_step` px of the coarsest level each way, and rolls that shift its
  // border by one.
  int retry_steps = 2;
  double retry_step = 2.5;
  int max_retries = 3;  // of the minima found there, best first, that are followed to the finest

  bool IsValid(std::string* error) const;
};

enum class TrackingStatus { kGood, kNoTexture, kLost };

struct TrackingResult {
  TrackingStatus status = TrackingStatus::kLost;
  FrameAlignmentResult alignment;
  int attempts = 0;
};

// Tracks frames against the latest keyframe: constant-velocity prediction first. When the result is
// bad, other starts are compared on the coarsest level and the best of them followed to the finest.
class Tracker {
 public:
  explicit Tracker(const TrackerOptions& options) : options_(options) {}

  // Frames that follow are aligned to this keyframe. `new_from_old_reference` carries the motion
  // model over (identity for the first keyframe).
  void SetReference(TrackingReference reference, const SE3& new_from_old_reference);

  TrackingResult Track(const ImagePyramid& target);

  // Median RMS of the last frames tracked, at least `min_typical_rms`, intensities.
  double TypicalRms() const;

  // Whether enough frames were tracked to know the typical RMS.
  bool KnowsFit() const { return recent_rms_.size() >= 3; }

  // Forgets motion and fit, for a new start; the reference stays.
  void Reset();

 private:
  bool KnowsMotion() const { return history_.size() == 2; }
  SE3 LastMotion() const;
  SE3 Travelled() const;
  AlignmentState Prediction() const;
  std::vector<AlignmentState> OtherStarts() const;
  bool IsGood(const FrameAlignmentResult& alignment) const;
  bool IsCredible(const FrameAlignmentResult& alignment) const;
  TrackingResult TryStarts(const ImagePyramid& target) const;

  TrackerOptions options_;
  TrackingReference reference_;
  // The last two frames, relative to the current reference; at first the reference itself.
  std::vector<AlignmentState> history_ = {AlignmentState()};
  std::vector<double> recent_rms_;  // of the last good frames
  int misses_ = 0;                  // frames not tracked since the last good one
};

}  // namespace prism
