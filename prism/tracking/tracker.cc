// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prism {
namespace {

double RmsGradient(const ImageViewF& image) {
  const ImageF squared = SquaredGradientMagnitude(image);
  double sum = 0;
  for (size_t i = 0; i < squared.size(); ++i) sum += squared.data()[i];
  return std::sqrt(sum / static_cast<double>(squared.size()));
}

}  // namespace

bool TrackerOptions::IsValid(std::string* error) const {
  if (!alignment.IsValid(error) || !fit.IsValid(error)) return false;
  if (min_rms_gradient >= 0 && retry_steps >= 0 && retry_step > 0 && max_retries >= 1) return true;
  *error =
      "tracking needs a gradient and retry steps of 0 or more, a positive retry step and a retry "
      "or more";
  return false;
}

void Tracker::SetReference(TrackingReference reference, const SE3& new_from_old_reference) {
  const SE3 old_from_new = new_from_old_reference.Inverse();
  for (TrackedFrame& frame : history_) {
    frame.state.target_from_reference = frame.state.target_from_reference * old_from_new;
  }
  // Brightness is relative to the reference too: the newest frame is (or is close to) the new one.
  const AlignmentState newest = history_.back().state;
  for (TrackedFrame& frame : history_) {
    frame.state.a -= newest.a;
    frame.state.b -= std::exp(frame.state.a) * newest.b;
  }
  reference_ = std::move(reference);
}

void Tracker::Start(TrackingReference reference, int64_t time_ns) {
  reference_ = std::move(reference);
  history_ = {{time_ns, AlignmentState()}};
}

SE3 Tracker::Motion(int64_t time_ns, double fraction) const {
  if (!KnowsMotion()) return SE3();
  const TrackedFrame& before = history_[0];
  const TrackedFrame& last = history_[1];
  const double known_ns = static_cast<double>(last.time_ns - before.time_ns);
  const double wanted_ns = static_cast<double>(time_ns - last.time_ns);
  if (!(known_ns > 0 && wanted_ns > 0)) return SE3();
  const SE3 motion =
      last.state.target_from_reference * before.state.target_from_reference.Inverse();
  return SE3::Exp(fraction * wanted_ns / known_ns * motion.Log());
}

AlignmentState Tracker::Prediction(int64_t time_ns) const {
  AlignmentState state = history_.back().state;
  state.target_from_reference = Motion(time_ns, 1) * state.target_from_reference;
  return state;
}

std::vector<AlignmentState> Tracker::OtherStarts(int64_t time_ns) const {
  std::vector<AlignmentState> starts;
  const AlignmentState& last = history_.back().state;
  const AlignmentState prediction = Prediction(time_ns);
  const auto add = [&](const SE3& motion, const AlignmentState& from) {
    starts.push_back(from);
    starts.back().target_from_reference = motion * from.target_from_reference;
  };
  add(SE3(), prediction);
  if (KnowsMotion()) {
    for (const double fraction : {0.5, 0.0, 2.0}) add(Motion(time_ns, fraction), last);
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

TrackingResult Tracker::Track(const ImagePyramid& target,
                              int64_t time_ns,
                              const NoiseModel& noise) {
  TrackingResult result = TryStarts(target, time_ns, noise);
  if (result.status != TrackingStatus::kGood) return result;
  history_.push_back({time_ns, result.alignment.state});
  if (history_.size() > 2) history_.erase(history_.begin());
  return result;
}

TrackingResult Tracker::TryStarts(const ImagePyramid& target,
                                  int64_t time_ns,
                                  const NoiseModel& noise) const {
  TrackingResult result;
  const ImageF& texture_level = target[std::min<size_t>(1, target.size() - 1)];
  if (RmsGradient(texture_level) < options_.min_rms_gradient) {
    result.status = TrackingStatus::kNoTexture;
    return result;
  }
  const auto align = [&](const AlignmentState& start) {
    return AlignFrame(reference_, target, start, noise, options_.alignment);
  };
  const auto is_good = [&](const FrameAlignmentResult& alignment) {
    return alignment.status == AlignmentStatus::kGood && options_.fit.good.AreMetBy(alignment.fit);
  };
  result.alignment = align(Prediction(time_ns));
  result.attempts = 1;
  if (!is_good(result.alignment)) {
    const SE3 first = result.alignment.state.target_from_reference;
    for (const AlignmentState& start :
         RankStarts(reference_, target, OtherStarts(time_ns), noise, options_.alignment)) {
      if (AreOneMinimum(reference_, start.target_from_reference, first)) continue;
      const FrameAlignmentResult alignment = align(start);
      ++result.attempts;
      const bool possible = alignment.status == AlignmentStatus::kGood;
      const bool best_is_possible = result.alignment.status == AlignmentStatus::kGood;
      if (possible && (!best_is_possible || alignment.fit.rms < result.alignment.fit.rms)) {
        result.alignment = alignment;
      }
      if (is_good(result.alignment) || result.attempts > options_.max_retries) break;
    }
  }
  const FitLimits& limits = noise.KnowsFit() ? options_.fit.match : options_.fit.start;
  if (result.alignment.status == AlignmentStatus::kGood && limits.AreMetBy(result.alignment.fit)) {
    result.status = TrackingStatus::kGood;
  }
  return result;
}

}  // namespace prism
