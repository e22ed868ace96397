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
#include "prism/image/smoothing.h"
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
    case FrameStatus::kHeld:
      return "held";
    case FrameStatus::kNoTexture:
      return "no texture";
    case FrameStatus::kLost:
      return "lost";
    case FrameStatus::kDepthsDisagree:
      return "depths disagree";
    case FrameStatus::kUnreadable:
      return "unreadable";
  }
  return "";
}

bool HasPose(FrameStatus status) {
  return status == FrameStatus::kTracked || status == FrameStatus::kHeld;
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
      tracker_(options.tracker),
      map_(options.joining.max_places) {
  std::string error;
  CHECK(options_.IsValid(&error)) << error;
  terms_.insert(terms_.end(), options.terms.begin(), options.terms.end());
}

FrameResult Odometry::Process(LightFieldFrame light_field_frame) {
  const FramePtr frame = Prepare(std::move(light_field_frame));
  if (window_.empty()) return Start(frame);

  RecoveryResult match;
  {
    const StageTimer::Scope scope(&timer_, "track");
    const auto check_depth = MakeDepthCheck(window_.noise, *frame, ExpectedDepthOffset(), 1);
    if (lost_frames_ > 0) {
      match = RecoverInWindow(*frame);
    } else {
      match.tracking = tracker_.Track(frame->image, frame->time_ns, window_.noise, check_depth);
      if (match.tracking.status == TrackingStatus::kGood) match.reference = &window_.newest();
    }
    if (match.tracking.status == TrackingStatus::kLost &&
        unmatched_frames_ <= options_.max_lost_frames && held_frames_ < options_.max_held_frames) {
      match.tracking = tracker_.Hold(frame->image, frame->time_ns, window_.noise, check_depth);
      if (match.tracking.status == TrackingStatus::kHeld) match.reference = &window_.newest();
    }
  }
  if (match.reference == nullptr) return HandleLoss(frame, match.tracking.status);

  const FrameAlignmentResult& alignment = match.tracking.alignment;
  const FrameState reference = match.reference->state;
  const bool is_held = match.tracking.status == TrackingStatus::kHeld;
  if (!is_held) {
    window_.noise.Observe(alignment.points.rms);
    window_.noise.ObserveDepthAgreement(alignment.fit.depth_agreement *
                                        window_.noise.UsualDepthAgreement());
    lost_frames_ = unmatched_frames_ = 0;
  }
  held_frames_ = is_held ? held_frames_ + 1 : 0;
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  result.status = is_held ? FrameStatus::kHeld : FrameStatus::kTracked;
  result.sigma = match.tracking.sigma;
  result.fit = alignment.fit;
  result.rms = alignment.points.rms;
  result.points_used = alignment.points.seen - alignment.points.outliers;
  result.keyframe_id = match.reference->id;
  result.state = Compose(alignment.state, reference);
  if (!is_held) {
    const StageTimer::Scope scope(&timer_, "update candidates");
    UpdateCandidates(options_.activation.candidates, frame->image[0], result.state, &window_);
  }
  const bool is_recovered = match.reference != &window_.newest();
  // A keyframe at a pose that is hardly known would spoil the map.
  const bool needs_keyframe = !is_held && (is_recovered || NeedsKeyframe(alignment,
                                                                         first_rms_,
                                                                         camera_.focused_width(),
                                                                         camera_.focused_height(),
                                                                         options_.keyframe));
  if (needs_keyframe) {
    if (options_.joining.close_loops) AddStepEdge(*frame, match);
    result.keyframe = MakeKeyframe(frame, result.state, reference.pose(), alignment.points);
    result.is_keyframe = true;
    result.keyframe_id = window_.newest().id;
    result.state = window_.newest().state;
    FindKeyframe(&result);
  } else {
    if (first_rms_ == 0 && !is_held) first_rms_ = alignment.points.rms;
    const size_t index =
        map_.AddFrame(frame->time_ns, match.reference->id, alignment.state.target_from_reference);
    recent_frames_.Add(*frame, alignment.state, index);
  }
  last_pose_ = result.state.pose() * map_.WorldFromSegment(segment_).Inverse();
  result.state.set_pose(last_pose_);
  result.active_points = window_.NumPoints();
  return result;
}

FrameResult Odometry::Skip(int64_t time_ns) const {
  FrameResult result;
  result.time_ns = time_ns;
  result.status = FrameStatus::kUnreadable;
  result.segment = segment_;
  if (window_.empty()) return result;
  if (const auto motion = tracker_.PredictMotion(time_ns)) {
    result.sigma = motion->sigma;
    result.state.set_pose(motion->target_from_reference * map_.CamFromWorld(window_.newest().id));
  }
  return result;
}

FrameResult Odometry::HandleLoss(FramePtr frame, TrackingStatus status) {
  ++lost_frames_;
  if (status != TrackingStatus::kNoTexture) ++unmatched_frames_;
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  if (const auto motion = tracker_.PredictMotion(frame->time_ns)) {
    result.sigma = motion->sigma;
    last_pose_ = motion->target_from_reference * map_.CamFromWorld(window_.newest().id);
    result.state.set_pose(last_pose_);
  }
  switch (status) {
    case TrackingStatus::kNoTexture:
      result.status = FrameStatus::kNoTexture;
      return result;
    case TrackingStatus::kDepthsDisagree:
      result.status = FrameStatus::kDepthsDisagree;
      break;
    default:
      result.status = FrameStatus::kLost;
  }
  const std::optional<Recognition> found = Recognize(*frame);
  if (!found && unmatched_frames_ <= options_.max_lost_frames) return result;
  FrameResult start = found ? StartSegment(WithKnownDepths(*frame, *found), found->world_from_cam)
                            : StartSegment(std::move(frame), last_pose_.Inverse());
  return start.status == FrameStatus::kTracked ? start : result;
}

Odometry::FramePtr Odometry::Prepare(LightFieldFrame frame) {
  CHECK(frame.image.at(0).width() == window_.camera.width &&
        frame.image.at(0).height() == window_.camera.height);
  const StageTimer::Scope scope(&timer_, "smooth image");
  given_image_ = std::move(frame.image[0]);
  frame.image = BuildPyramid(Smooth(given_image_), static_cast<int>(frame.image.size()));
  return std::make_shared<const LightFieldFrame>(std::move(frame));
}

FrameResult Odometry::Start(const FramePtr& frame) {
  window_.noise = InitialNoise();
  const std::optional<Recognition> found = Recognize(*frame);
  return StartSegment(found ? WithKnownDepths(*frame, *found) : frame, last_pose_.Inverse());
}

FrameResult Odometry::StartSegment(FramePtr frame, const SE3& world_from_segment) {
  FrameResult result;
  result.time_ns = frame->time_ns;
  result.segment = segment_;
  // What is known of the segment before goes to the map once the new one has begun.
  Window before(window_.camera);
  std::swap(before, window_);
  window_.next_point_id = before.next_point_id;
  window_.states = before.states;
  for (StateBlock& state : window_.states) state.first_estimate.reset();
  window_.noise = InitialNoise();
  AddKeyframe(std::move(frame), FrameState());
  ActivatePoints(options_.activation, terms_, options_.window.max_points, &window_);
  if (window_.NumPoints() < options_.min_start_points) {
    std::swap(before, window_);
    --next_keyframe_id_;
    result.status = FrameStatus::kNoTexture;
    return result;
  }
  if (!before.empty()) {
    for (const auto& keyframe : before.keyframes) map_.AddPlace(MakePlaceOf(before, *keyframe));
    map_.AddPoints(ForgetWindow(&before));
    ++segment_;
  }
  lost_frames_ = unmatched_frames_ = held_frames_ = 0;
  recent_frames_.Clear();
  joiner_.Reset();
  sightings_.clear();
  keyframes_to_settle_ = 0;
  AnchorFirstKeyframe(&window_);
  map_.StartSegment(segment_, world_from_segment);
  map_.RememberKeyframes(window_, segment_);
  map_.AddFrame(window_.newest().frame->time_ns, window_.newest().id, SE3());
  const LightFieldFrame& newest = *window_.newest().frame;
  tracker_.Start(MakeReference(window_.newest()), newest.image, newest.time_ns);
  first_rms_ = 0;
  FindKeyframe(&result);
  last_pose_ = map_.WorldFromSegment(segment_).Inverse();
  result.segment = segment_;
  result.status = FrameStatus::kTracked;
  result.is_keyframe = true;
  result.keyframe_id = window_.newest().id;
  result.state = FrameState(last_pose_, 0, 0);
  result.active_points = window_.NumPoints();
  return result;
}

NoiseModel Odometry::InitialNoise() const {
  // The estimate takes noise to be white, which that of the smoothed image is not.
  return NoiseModel(kSmoothedNoise * EstimateImageNoise(given_image_),
                    options_.photometric_model_sigma);
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
  }
  if (result.optimization.uncertainty) {
    window_.noise.ObserveDepthOffsets(result.optimization.uncertainty->keyframe_offset_square);
  }
  map_.RememberKeyframes(window_, segment_);
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
      map_.AddPlace(MakePlaceOf(window_, window_.Get(id)));
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
