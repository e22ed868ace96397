// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <glog/logging.h>

#include "prism/factors/prior_term.h"
#include "prism/image/noise.h"
#include "prism/odometry/recovery.h"
#include "prism/points/hidden_points.h"
#include "prism/tracking/depth_agreement.h"
#include "prism/tracking/reference_points.h"

namespace prism {
namespace {

// Absolute pose and brightness of a frame from its alignment to a keyframe:
// I_new = e^a I_ref + b and I_ref = e^(a_ref) L + b_ref.
FrameState Compose(const AlignmentState& alignment, const FrameState& reference) {
  return FrameState(alignment.target_from_reference * reference.pose(),
                    reference.a() + alignment.a,
                    std::exp(alignment.a) * reference.b() + alignment.b);
}

// Of the points that do not fit a frame in which many do not: those are hidden. In other frames the
// robust loss does better than a verdict that trusts the tracked pose.
std::set<int> HiddenPoints(const TrackingReference& reference, const PointFits& points) {
  std::set<int> ids;
  if (!points.AreManyHidden()) return ids;
  for (size_t i = 0; i < points.fits.size(); ++i) {
    if (points.fits[i] == PointFit::kOutlier) ids.insert(reference.points[i].point_id);
  }
  return ids;
}

// The worst of the terms says how the window fits.
KeyframeStatus Judge(const KeyframeResult& result,
                     const NoiseModel& noise,
                     const FitLimits& limits) {
  if (!result.optimization.solve.usable) return KeyframeStatus::kNotSolved;
  FitQuality fit;
  fit.rms = fit.outlier_fraction = 0;
  fit.visible_fraction = 1;
  for (size_t i = 0; i < result.optimization.terms.size(); ++i) {
    const TermSummary& term = result.optimization.terms[i];
    if (term.factors == 0) continue;
    // Residuals of images are known to be larger than stated by the misfit.
    const double expected = term.name == PhotometricTerm::kName ? noise.WeightedFitSigma() : 1;
    fit.rms = std::max(fit.rms, std::sqrt(term.variance_factor) / expected);
    fit.outlier_fraction =
        std::max(fit.outlier_fraction,
                 static_cast<double>(result.outliers.factors_rejected[i]) / term.factors);
  }
  return limits.AreMetBy(fit) ? KeyframeStatus::kGood : KeyframeStatus::kPoorFit;
}

}  // namespace

const char* ToString(FrameStatus status) {
  switch (status) {
    case FrameStatus::kTracked:
      return "tracked";
    case FrameStatus::kNoTexture:
      return "no texture";
    case FrameStatus::kLost:
      return "lost";
    case FrameStatus::kDepthsDisagree:
      return "depths disagree";
  }
  return "";
}

const char* ToString(KeyframeStatus status) {
  switch (status) {
    case KeyframeStatus::kGood:
      return "good";
    case KeyframeStatus::kPoorFit:
      return "poor fit";
    case KeyframeStatus::kNotSolved:
      return "not solved";
  }
  return "";
}

Odometry::Odometry(const PlenopticCamera& camera, const OdometryOptions& options)
    : camera_(camera),
      options_(options),
      terms_(MakeDefaultTerms(options.default_terms)),
      window_(PlenopticProjection(camera)),
      tracker_(options.tracker) {
  std::string error;
  CHECK(options_.IsValid(&error)) << error;
  terms_.insert(terms_.end(), options.terms.begin(), options.terms.end());
}

FrameResult Odometry::Process(LightFieldFrame light_field_frame) {
  const auto frame = std::make_shared<const LightFieldFrame>(std::move(light_field_frame));
  CHECK(frame->image.at(0).width() == window_.camera.width &&
        frame->image.at(0).height() == window_.camera.height);
  if (window_.empty()) return StartSegment(frame);

  RecoveryResult match;
  {
    const StageTimer::Scope scope(&timer_, "track");
    if (lost_frames_ > 0) {
      match = Recover(options_.tracker.fit.recovered, camera_, window_, *frame, &tracker_);
    } else {
      match.tracking = tracker_.Track(
          frame->image,
          frame->time_ns,
          window_.noise,
          MakeDepthCheck(window_.noise, *frame, PersistentDepthOffset(window_.newest()), 1));
      if (match.tracking.status == TrackingStatus::kGood) match.reference = &window_.newest();
    }
  }
  if (match.reference == nullptr) return HandleLoss(frame, match.tracking.status);

  const FrameAlignmentResult& alignment = match.tracking.alignment;
  const FrameState reference = match.reference->state;
  window_.noise.Observe(alignment.points.rms);
  window_.noise.ObserveDepthAgreement(alignment.fit.depth_agreement *
                                      window_.noise.UsualDepthAgreement());
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  result.status = FrameStatus::kTracked;
  result.fit = alignment.fit;
  result.rms = alignment.points.rms;
  result.points_used = alignment.points.seen - alignment.points.outliers;
  result.keyframe_id = match.reference->id;
  result.state = Compose(alignment.state, reference);
  {
    const StageTimer::Scope scope(&timer_, "update candidates");
    UpdateCandidates(options_.activation.candidates, frame->image[0], result.state, &window_);
  }
  const bool is_recovered = match.reference != &window_.newest();
  if (is_recovered || NeedsKeyframe(alignment,
                                    first_rms_,
                                    camera_.focused_width(),
                                    camera_.focused_height(),
                                    options_.keyframe)) {
    result.keyframe = MakeKeyframe(frame, result.state, reference.pose(), alignment.points);
    result.is_keyframe = true;
    result.keyframe_id = window_.newest().id;
    result.state = window_.newest().state;
  } else {
    if (first_rms_ == 0) first_rms_ = alignment.points.rms;
    const size_t index =
        map_.AddFrame(frame->time_ns, match.reference->id, alignment.state.target_from_reference);
    recent_frames_.Add(*frame, alignment.state, index);
  }
  lost_frames_ = 0;
  last_pose_ = result.state.pose();
  result.active_points = window_.NumPoints();
  return result;
}

FrameResult Odometry::HandleLoss(FramePtr frame, TrackingStatus status) {
  ++lost_frames_;
  if (lost_frames_ > options_.max_lost_frames && status != TrackingStatus::kNoTexture) {
    // Everything the window holds goes to the map; the new segment knows nothing of it.
    map_.AddPoints(ForgetWindow(&window_));
    ++segment_;
    return StartSegment(std::move(frame));
  }
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  switch (status) {
    case TrackingStatus::kNoTexture:
      result.status = FrameStatus::kNoTexture;
      break;
    case TrackingStatus::kDepthsDisagree:
      result.status = FrameStatus::kDepthsDisagree;
      break;
    default:
      result.status = FrameStatus::kLost;
  }
  return result;
}

FrameResult Odometry::StartSegment(FramePtr frame) {
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  window_.noise = NoiseModel(EstimateImageNoise(frame->image[0]), options_.photometric_model_sigma);
  AddKeyframe(std::move(frame), FrameState(last_pose_, 0, 0));
  ActivatePoints(options_.activation, terms_, options_.window.max_points, &window_);
  if (window_.NumPoints() < options_.min_start_points) {
    window_.keyframes.clear();
    --next_keyframe_id_;
    result.status = FrameStatus::kNoTexture;
    return result;
  }
  lost_frames_ = 0;
  recent_frames_.Clear();
  AnchorFirstKeyframe(&window_);
  map_.RememberKeyframes(window_);
  map_.AddFrame(window_.newest().frame->time_ns, window_.newest().id, SE3());
  const LightFieldFrame& newest = *window_.newest().frame;
  tracker_.Start(MakeReference(window_.newest()), newest.image, newest.time_ns);
  first_rms_ = 0;
  result.status = FrameStatus::kTracked;
  result.is_keyframe = true;
  result.keyframe_id = window_.newest().id;
  result.state = window_.newest().state;
  result.active_points = window_.NumPoints();
  return result;
}

// Puts a keyframe at a state into the window.
void Odometry::AddKeyframe(FramePtr frame, const FrameState& state) {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->id = next_keyframe_id_++;
  keyframe->frame = std::move(frame);
  keyframe->state = state;
  window_.keyframes.push_back(std::move(keyframe));
  for (const auto& term : terms_) term->AddStates(&window_);
}

KeyframeResult Odometry::MakeKeyframe(FramePtr frame,
                                      const FrameState& state,
                                      const SE3& reference_pose,
                                      const PointFits& point_fits) {
  KeyframeResult result;
  AddKeyframe(std::move(frame), state);
  MarkHiddenPoints(HiddenPoints(tracker_.reference(), point_fits), &window_);
  {
    const StageTimer::Scope scope(&timer_, "activate points");
    ActivatePoints(options_.activation, terms_, options_.window.max_points, &window_);
  }
  {
    const StageTimer::Scope scope(&timer_, "optimize window");
    result.optimization = OptimizeWindow(options_.window, terms_, &window_);
  }
  {
    const StageTimer::Scope scope(&timer_, "remove outliers");
    result.outliers = RemoveOutliers(terms_, options_.window.graph, &window_);
  }
  result.status = Judge(result, window_.noise, options_.tracker.fit.match);
  if (result.status == KeyframeStatus::kGood) {
    window_.noise.ObserveWindow(result.optimization.VarianceFactor(PhotometricTerm::kName),
                                result.optimization.VarianceFactor(InverseVirtualDepthTerm::kName));
    if (result.optimization.uncertainty) {
      window_.noise.ObserveDepthOffsets(result.optimization.uncertainty->keyframe_offset_square);
    }
  }
  map_.RememberKeyframes(window_);
  {
    const StageTimer::Scope scope(&timer_, "realign frames");
    const Keyframe& before = *window_.keyframes[window_.keyframes.size() - 2];
    recent_frames_.Realign(MakeReference(before), window_.noise, options_.tracker.alignment, &map_);
  }
  map_.AddFrame(window_.newest().frame->time_ns, window_.newest().id, SE3());
  tracker_.SetReference(MakeReference(window_.newest()),
                        window_.newest().state.pose() * reference_pose.Inverse());
  first_rms_ = 0;
  {
    const StageTimer::Scope scope(&timer_, "marginalize");
    for (const int id : KeyframesToRetire(options_.window, options_.retirement, window_)) {
      map_.AddPoints(RetireKeyframe(options_.window, terms_, id, &window_).points);
    }
  }
  return result;
}

// A keyframe of the window as frames are aligned to it.
TrackingReference Odometry::MakeReference(const Keyframe& keyframe) {
  const StageTimer::Scope scope(&timer_, "make reference");
  return MakeTrackingReference(
      camera_, keyframe.frame->image, MakeReferencePoints(window_, keyframe));
}

}  // namespace prism
