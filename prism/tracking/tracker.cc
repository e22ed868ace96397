// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prism/base/stage_timer.h"

namespace prism {
namespace {

double RmsGradient(const ImageViewF& image) {
  const ImageF squared = SquaredGradientMagnitude(image);
  double sum = 0;
  for (size_t i = 0; i < squared.size(); ++i) sum += squared.data()[i];
  return std::sqrt(sum / static_cast<double>(squared.size()));
}

// Half a motion.
SE3 Half(const SE3& motion) { return SE3::Exp(0.5 * motion.Log()); }

}  // namespace

bool TrackerOptions::IsValid(std::string* error) const {
  if (!alignment.IsValid(error)) return false;
  if (retry_rms_ratio >= 1 && max_rms_ratio >= retry_rms_ratio && min_rms_gradient >= 0 &&
      retry_rotation > 0)
    return true;
  *error =
      "tracking needs RMS ratios of 1 or more, a gradient of 0 or more and a positive "
      "retry rotation";
  return false;
}

void Tracker::SetReference(TrackingReference reference, const SE3& new_from_old_reference) {
  const SE3 old_from_new = new_from_old_reference.Inverse();
  for (AlignmentState& state : history_) {
    state.target_from_reference = state.target_from_reference * old_from_new;
  }
  // Brightness is relative to the reference too: the newest frame is (or is close to) the new one.
  if (!history_.empty()) {
    const AlignmentState newest = history_.back();
    for (AlignmentState& state : history_) {
      state.a -= newest.a;
      state.b -= std::exp(state.a) * newest.b;
    }
  }
  reference_ = std::move(reference);
}

void Tracker::Reset() {
  history_.clear();
  recent_rms_.clear();
  misses_ = 0;
}

double Tracker::TypicalRms() const {
  return std::max(Quantile(recent_rms_, 0.5), options_.min_typical_rms);
}

std::vector<AlignmentState> Tracker::Predictions() const {
  std::vector<AlignmentState> predictions;
  if (history_.empty()) {
    predictions.emplace_back();
  } else {
    const AlignmentState& last = history_.back();
    const auto add = [&](const SE3& motion) {
      AlignmentState state = last;
      state.target_from_reference = motion * last.target_from_reference;
      predictions.push_back(state);
    };
    const SE3 motion = history_.size() < 2 ? SE3()
                                           : last.target_from_reference *
                                                 history_[0].target_from_reference.Inverse();
    // As many steps as frames have passed since the last good one.
    SE3 travelled = motion;
    for (int i = 0; i < misses_; ++i) travelled = motion * travelled;
    add(travelled);
    add(Half(travelled));
    add(SE3());
    add(motion * travelled);
    predictions.emplace_back();  // back at the keyframe
  }
  // Rotations about the first prediction.
  const AlignmentState base = predictions[0];
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector6d delta = Vector6d::Zero();
      delta(3 + axis) = sign * options_.retry_rotation;
      AlignmentState state = base;
      state.target_from_reference = SE3::Exp(delta) * base.target_from_reference;
      predictions.push_back(state);
    }
  }
  return predictions;
}

TrackingResult Tracker::Track(const ImagePyramid& target) {
  TrackingResult result = TryPredictions(target);
  if (result.status != TrackingStatus::kGood) {
    ++misses_;
    return result;
  }
  misses_ = 0;
  constexpr size_t kRecentFrames = 30;
  recent_rms_.push_back(result.alignment.rms);
  if (recent_rms_.size() > kRecentFrames) recent_rms_.erase(recent_rms_.begin());
  history_.push_back(result.alignment.state);
  if (history_.size() > 2) history_.erase(history_.begin());
  return result;
}

TrackingResult Tracker::TryPredictions(const ImagePyramid& target) const {
  TrackingResult result;
  const ImageF& texture_level = target[std::min<size_t>(1, target.size() - 1)];
  if (RmsGradient(texture_level) < options_.min_rms_gradient) {
    result.status = TrackingStatus::kNoTexture;
    return result;
  }
  const double typical_rms = TypicalRms();
  for (const AlignmentState& prediction : Predictions()) {
    const FrameAlignmentResult alignment =
        AlignFrame(reference_, target, prediction, options_.alignment);
    ++result.attempts;
    const bool good = alignment.status == AlignmentStatus::kGood;
    const bool best_is_good = result.alignment.status == AlignmentStatus::kGood;
    if (result.attempts == 1 || (good && (!best_is_good || alignment.rms < result.alignment.rms))) {
      result.alignment = alignment;
    }
    if (good && (recent_rms_.empty() || alignment.rms < options_.retry_rms_ratio * typical_rms))
      break;
  }
  if (result.alignment.status == AlignmentStatus::kGood &&
      (recent_rms_.empty() || result.alignment.rms < options_.max_rms_ratio * typical_rms)) {
    result.status = TrackingStatus::kGood;
  }
  return result;
}

}  // namespace prism
