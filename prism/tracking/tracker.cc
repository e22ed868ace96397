// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prism/base/statistics.h"

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
      max_outlier_fraction > 0 && max_start_outlier_fraction > 0 && retry_steps >= 0 &&
      retry_step > 0 && max_retries >= 1) {
    return true;
  }
  *error =
      "tracking needs RMS ratios of 1 or more, a gradient of 0 or more, positive outlier "
      "fractions, "
      "a positive retry step and a retry or more";
  return false;
}

void Tracker::SetReference(TrackingReference reference, const SE3& new_from_old_reference) {
  const SE3 old_from_new = new_from_old_reference.Inverse();
  for (AlignmentState& state : history_) {
    state.target_from_reference = state.target_from_reference * old_from_new;
  }
  // Brightness is relative to the reference too: the newest frame is (or is close to) the new one.
  const AlignmentState newest = history_.back();
  for (AlignmentState& state : history_) {
    state.a -= newest.a;
    state.b -= std::exp(state.a) * newest.b;
  }
  reference_ = std::move(reference);
}

void Tracker::Reset() {
  history_ = {AlignmentState()};
  recent_rms_.clear();
  misses_ = 0;
}

double Tracker::TypicalRms() const {
  return std::max(Quantile(recent_rms_, 0.5), options_.min_typical_rms);
}

SE3 Tracker::LastMotion() const {
  if (!KnowsMotion()) return SE3();
  return history_[1].target_from_reference * history_[0].target_from_reference.Inverse();
}

// As many steps as frames have passed since the last good one.
SE3 Tracker::Travelled() const {
  const SE3 motion = LastMotion();
  SE3 travelled = motion;
  for (int i = 0; i < misses_; ++i) travelled = motion * travelled;
  return travelled;
}

AlignmentState Tracker::Prediction() const {
  AlignmentState state = history_.back();
  state.target_from_reference = Travelled() * state.target_from_reference;
  return state;
}

std::vector<AlignmentState> Tracker::OtherStarts() const {
  std::vector<AlignmentState> starts;
  const AlignmentState& last = history_.back();
  const AlignmentState prediction = Prediction();
  const auto add = [&](const SE3& motion, const AlignmentState& from) {
    starts.push_back(from);
    starts.back().target_from_reference = motion * from.target_from_reference;
  };
  add(SE3(), prediction);
  if (KnowsMotion()) {
    add(Half(Travelled()), last);
    add(SE3(), last);
    add(LastMotion() * Travelled(), last);
  }
  starts.emplace_back();  // back at the keyframe
  if (reference_.cameras.empty()) return starts;

  const PlenopticProjection& coarsest = reference_.cameras.back();
  const auto turn = [&](double x, double y, double z) {
    add(SE3::Exp((Vector6d() << 0, 0, 0, x, y, z).finished()), prediction);
  };
  const double step = options_.retry_step / coarsest.FocalLengthPx();
  for (int y = -options_.retry_steps; y <= options_.retry_steps; ++y) {
    for (int x = -options_.retry_steps; x <= options_.retry_steps; ++x) {
      if (x != 0 || y != 0) turn(step * x, step * y, 0);
    }
  }
  const double roll = 2 * options_.retry_step / coarsest.width;
  turn(0, 0, roll);
  turn(0, 0, -roll);
  return starts;
}

TrackingResult Tracker::Track(const ImagePyramid& target) {
  TrackingResult result = TryStarts(target);
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

// Before any motion is known the prediction may be far off, and a false minimum looks typical: the
// fit is held against the best there is.
bool Tracker::IsGood(const FrameAlignmentResult& alignment) const {
  const double rms = KnowsMotion() ? TypicalRms() : options_.min_typical_rms;
  return alignment.status == AlignmentStatus::kGood &&
         alignment.rms < options_.retry_rms_ratio * rms &&
         alignment.outlier_fraction <= options_.max_outlier_fraction;
}

TrackingResult Tracker::TryStarts(const ImagePyramid& target) const {
  TrackingResult result;
  const ImageF& texture_level = target[std::min<size_t>(1, target.size() - 1)];
  if (RmsGradient(texture_level) < options_.min_rms_gradient) {
    result.status = TrackingStatus::kNoTexture;
    return result;
  }
  result.alignment = AlignFrame(reference_, target, Prediction(), options_.alignment);
  result.attempts = 1;
  if (!IsGood(result.alignment)) {
    const SE3 first = result.alignment.state.target_from_reference;
    for (const AlignmentState& start :
         RankStarts(reference_, target, OtherStarts(), options_.alignment)) {
      if (AreOneMinimum(reference_, start.target_from_reference, first)) continue;
      const FrameAlignmentResult alignment =
          AlignFrame(reference_, target, start, options_.alignment);
      ++result.attempts;
      const bool good = alignment.status == AlignmentStatus::kGood;
      const bool best_is_good = result.alignment.status == AlignmentStatus::kGood;
      if (good && (!best_is_good || alignment.rms < result.alignment.rms)) {
        result.alignment = alignment;
      }
      if (IsGood(result.alignment) || result.attempts > options_.max_retries) break;
    }
  }
  if (result.alignment.status == AlignmentStatus::kGood && IsCredible(result.alignment)) {
    result.status = TrackingStatus::kGood;
  }
  return result;
}

bool Tracker::IsCredible(const FrameAlignmentResult& alignment) const {
  if (!KnowsFit() && alignment.outlier_fraction > options_.max_start_outlier_fraction) return false;
  return recent_rms_.empty() || alignment.rms < options_.max_rms_ratio * TypicalRms();
}

}  // namespace prism
