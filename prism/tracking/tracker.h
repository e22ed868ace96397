// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "prism/tracking/frame_alignment.h"

namespace prism {

struct TrackerOptions {
  AlignmentOptions alignment;
  FitOptions fit;
  // A frame whose root mean squared gradient is below this shows nothing; 0 to 255 a px.
  double min_rms_gradient = 0.5;
  // Other starts, beside those of the motion model: turns that shift the image by up to
  // `retry_steps` of `retry_step` px of the coarsest level each way, and rolls that shift its
  // border by one.
  int retry_steps = 2;
  double retry_step = 2.5;
  int exclude_after = 2;  // frames in a row in which a point of the reference does not fit
  // A fit from another start than the predicted one has to cost less than this times that one.
  double max_cost_ratio = 0.6;
  int max_retries = 3;  // of the minima found there, best first, that are followed to the finest
  // A frame that does not match is held (Hold) if it shows this many points of the reference, and
  // this share of them, ends within this many standard deviations of where motion predicts it, no
  // more than this many frames after the last one with a pose, and shows less than usual: root mean
  // squared gradient over the median of the last frames'.
  int min_held_points = 15;
  double min_held_fraction = 0.05;  // by chance 2 to 3 % fit somewhere near
  double max_held_distance = 5;
  double max_held_steps = 3;
  double max_held_gradient = 0.6;

  bool IsValid(std::string* error) const;
};

enum class TrackingStatus {
  kGood,
  kHeld,  // the view shows too little for a match: what it shows and the motion before say where
  kNoTexture,
  kLost,
  kDepthsDisagree
};

// Standard deviations of a pose, of each axis, in the target frame.
struct PoseSigma {
  double translation_m = 0;
  double rotation_rad = 0;
};

struct TrackingResult {
  TrackingStatus status = TrackingStatus::kLost;
  FrameAlignmentResult alignment;
  int attempts = 0;
  PoseSigma sigma;  // of the alignment, relative to the reference; kGood and kHeld
};

// Where a frame is by motion alone.
struct MotionPrediction {
  SE3 target_from_reference;
  PoseSigma sigma;

  // Of another pose, in standard deviations.
  double DistanceTo(const SE3& other_target_from_reference) const;
};

// Tracks frames against the latest keyframe: constant-velocity prediction first. When the result is
// not good (FitOptions::good), or nothing predicts it (the first frame after Start), other starts
// are compared on the coarsest level and the best of them followed to the finest.
class Tracker {
 public:
  explicit Tracker(const TrackerOptions& options) : options_(options) {}

  // Frames that follow are aligned to this keyframe. `new_from_old_reference` carries the motion
  // model over.
  void SetReference(TrackingReference reference, const SE3& new_from_old_reference);

  // For a new start: motion is forgotten, and the last frame is the reference itself, `image` taken
  // at `time_ns`.
  void Start(TrackingReference reference, const ImagePyramid& image, int64_t time_ns);

  // FitQuality::depth_agreement of an aligned frame.
  using DepthCheck = std::function<double(const TrackingReference&, const FrameAlignmentResult&)>;

  // Times rise from frame to frame; frames may be missing in between.
  TrackingResult Track(const ImagePyramid& target,
                       int64_t time_ns,
                       const NoiseModel& noise,
                       const DepthCheck& check_depth = nullptr);

  // For a frame that Track did not match, because its view shows too little: what it shows and the
  // motion before (PredictMotion) say where it is, each with its certainty. kHeld or kLost.
  TrackingResult Hold(const ImagePyramid& target,
                      int64_t time_ns,
                      const NoiseModel& noise,
                      const DepthCheck& check_depth = nullptr);

  // Constant velocity since the last tracked frame, and how far off that has been of late. Nothing
  // before that is known, and more than 15 frames after the last.
  std::optional<MotionPrediction> PredictMotion(int64_t time_ns) const;

  const TrackingReference& reference() const { return reference_; }

 private:
  // A tracked frame relative to the current reference.
  struct TrackedFrame {
    int64_t time_ns = 0;
    AlignmentState state;
  };

  bool KnowsMotion() const { return history_.size() == 2; }
  // Time since the last tracked frame, in that between it and the one before; 0: motion is not
  // known.
  double StepsTo(int64_t time_ns) const;
  // Motion at constant velocity since the last tracked frame, in fractions of the time to
  // `time_ns`.
  SE3 Motion(int64_t time_ns, double fraction) const;
  AlignmentState Prediction(int64_t time_ns) const;
  // Its brightness that of the last frame, or changed as the images' intensities have (exposure),
  // whichever fits the image better.
  AlignmentState WithBrightness(const ImagePyramid& target,
                                const std::vector<double>& intensities,
                                const NoiseModel& noise,
                                const AlignmentState& prediction) const;
  std::vector<AlignmentState> OtherStarts(int64_t time_ns, const AlignmentState& prediction) const;
  // The best alignment from the prediction and, if that is not good or motion is not known, from
  // other starts; without a verdict.
  TrackingResult TryStarts(const ImagePyramid& target,
                           int64_t time_ns,
                           const AlignmentState& prediction,
                           const NoiseModel& noise) const;
  void Judge(const NoiseModel& noise, const DepthCheck& check_depth, TrackingResult* result) const;
  void Remember(int64_t time_ns, const AlignmentState& state, std::vector<double> intensities);
  void ObserveMotion(int64_t time_ns, const SE3& target_from_reference);
  // Points that did not fit `exclude_after` frames in a row are left out until they fit again.
  void ExcludePoints(const std::vector<PointFit>& fits);

  TrackerOptions options_;
  TrackingReference reference_;
  std::vector<int> misfits_;  // of each point of the reference, frames in a row
  std::vector<TrackedFrame> history_ = {TrackedFrame()};  // the last two
  std::vector<double> gradients_;                         // RMS, of the last tracked frames
  std::vector<PoseSigma> motion_errors_;  // of the last predictions, as if one frame ahead
  std::vector<double>
      last_intensities_;  // of the last tracked frame, see Intensities in tracker.cc
};

}  // namespace prism
