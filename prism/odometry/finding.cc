// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// What Odometry does to find itself in what it has seen before: in the window after a loss, among
// places, and for loops.
#include <utility>

#include <glog/logging.h>

#include "prism/factors/depth_offset_term.h"
#include "prism/map/place_points.h"
#include "prism/map/place_view.h"
#include "prism/odometry/odometry.h"
#include "prism/tracking/reference_points.h"

namespace prism {

void Odometry::LoadPlaces(const std::vector<MappedPlace>& places) {
  CHECK(window_.empty()) << "places are loaded before the first frame";
  map_.Load(places);
  next_keyframe_id_ = map_.LastKeyframeId() + 1;
}

Map Odometry::CompleteMap() const {
  Map map = map_;
  for (const auto& keyframe : window_.keyframes) map.AddPlace(MakePlaceOf(window_, *keyframe));
  return map;
}

RecoveryResult Odometry::RecoverInWindow(const LightFieldFrame& frame) {
  Tracker tracker = tracker_;
  RecoveryResult match = Recover(options_.tracker.fit.recovered, camera_, window_, frame, &tracker);
  if (match.reference == nullptr) return match;
  // What repeats looks alike. It is believed near where motion predicts it; elsewhere the frame's
  // own depths have to find the keyframe as well.
  const SE3& target_from_reference = match.tracking.alignment.state.target_from_reference;
  const SE3 target_from_newest = target_from_reference * match.reference->state.pose() *
                                 window_.newest().state.pose().Inverse();
  const std::optional<MotionPrediction> motion = tracker_.PredictMotion(frame.time_ns);
  const bool is_expected =
      motion && motion->DistanceTo(target_from_newest) <= options_.max_motion_distance;
  if (!is_expected &&
      !VerifyMatch(
          camera_,
          MakePlaceOf(window_, *match.reference),
          MakePlaceQuery(camera_, frame, options_.activation.selection, options_.joining.match),
          target_from_reference,
          window_.noise,
          ExpectedDepthOffset(),
          options_.tracker.alignment,
          options_.joining.match)) {
    match.reference = nullptr;
    match.tracking.status = TrackingStatus::kLost;
    return match;
  }
  tracker_ = std::move(tracker);
  return match;
}

std::optional<Odometry::Recognition> Odometry::Recognize(const LightFieldFrame& frame) {
  if (!options_.joining.join || map_.places().empty()) return std::nullopt;
  const StageTimer::Scope scope(&timer_, "recognize places");
  std::vector<const Place*> places;
  for (const auto& [id, place] : map_.places()) places.push_back(&place);
  const PlaceQuery query =
      MakePlaceQuery(camera_, frame, options_.activation.selection, options_.joining.match);
  std::vector<SegmentPlacement> placements;
  std::vector<ReferencePoint> points;
  for (const PlaceMatch& match : FindPlaces(places, query)) {
    placements.push_back(PlaceSegment(map_, match, SE3()));
    const std::vector<ReferencePoint> seen =
        PointsSeenFrom(window_.camera, map_.places().at(match.keyframe_id), match.query_from_known);
    points.insert(points.end(), seen.begin(), seen.end());
  }
  SegmentJoiner joiner;
  JoiningOptions one = options_.joining;
  one.min_agreeing = 1;
  const auto placement = joiner.Observe(one, placements, query.reference);
  if (!placement) return std::nullopt;
  return Recognition{placement->world_from_segment, std::move(points)};
}

Odometry::FramePtr Odometry::WithKnownDepths(const LightFieldFrame& frame,
                                             const Recognition& recognition) const {
  return std::make_shared<const LightFieldFrame>(
      prism::WithKnownDepths(window_.camera, frame, ExpectedDepthOffset(), recognition.points));
}

double Odometry::ExpectedDepthOffset() const {
  return window_.empty() ? 0 : PersistentDepthOffset(window_.newest());
}

std::vector<PlaceMatch> Odometry::FindPlaces(const std::vector<const Place*>& places,
                                             const PlaceQuery& query) const {
  return FindMatches(camera_,
                     places,
                     query,
                     window_.noise,
                     ExpectedDepthOffset(),
                     options_.tracker.alignment,
                     options_.joining.match);
}

std::vector<const Place*> Odometry::PlacesToFind() const {
  const JoiningOptions& options = options_.joining;
  std::vector<const Place*> places;
  for (const auto& [id, place] : map_.places()) {
    const int segment = map_.SegmentOf(id);
    const bool is_joined = map_.Piece(segment) == map_.Piece(segment_);
    const bool closes_loop =
        options.close_loops && id + options.min_loop_keyframes <= window_.newest().id;
    const bool settles = keyframes_to_settle_ > 0 && segment != segment_;
    if (is_joined ? closes_loop || settles : options.join) places.push_back(&place);
  }
  return places;
}

void Odometry::FindKeyframe(FrameResult* result) {
  result->joined = JoinSegment();
  if (result->joined) {
    sightings_.clear();
    keyframes_to_settle_ = options_.joining.settling_keyframes;
  } else if (!sightings_.empty() &&
             window_.keyframes.front()->id <= sightings_.back().keyframe_id) {
    const std::optional<SE3> world_from_segment = FitSegment(map_, segment_, sightings_);
    if (world_from_segment) map_.PlaceSegment(segment_, *world_from_segment);
    result->has_settled = world_from_segment.has_value();
  }
  if (keyframes_to_settle_ > 0) --keyframes_to_settle_;
}

std::optional<JoinedSegment> Odometry::JoinSegment() {
  const JoiningOptions& options = options_.joining;
  const Keyframe& keyframe = window_.newest();
  const std::vector<const Place*> places = PlacesToFind();
  if (places.empty()) return std::nullopt;
  const StageTimer::Scope scope(&timer_, "recognize places");
  const PlaceQuery query =
      MakePlaceQuery(camera_, *keyframe.frame, options_.activation.selection, options.match);
  std::vector<SegmentPlacement> placements;
  for (const PlaceMatch& match : FindPlaces(places, query)) {
    const SegmentPlacement placement = PlaceSegment(map_, match, keyframe.state.pose());
    if (placement.onto_piece != map_.Piece(segment_)) {
      placements.push_back(placement);
    } else if (!IsPlausibleLoop(options, map_, match, keyframe.id)) {
      continue;
    } else if (keyframes_to_settle_ > 0 && map_.SegmentOf(match.keyframe_id) != segment_ &&
               (sightings_.empty() || sightings_.back().keyframe_id != keyframe.id)) {
      sightings_.push_back({keyframe.id,
                            match.query_from_known * map_.CamFromWorld(match.keyframe_id),
                            1 / query.place.median_rho});
    }
    map_.AddEdge(
        {match.keyframe_id,
         keyframe.id,
         match.query_from_known,
         EdgeInformation(match.information, match.query_from_known, query.place.median_rho),
         true});
  }
  const std::optional<SegmentPlacement> placement =
      joiner_.Observe(options, placements, query.reference);
  if (!placement) return std::nullopt;
  const SE3 moved = map_.Join(segment_, placement->onto_piece, placement->world_from_segment);
  joiner_.Reset();
  return JoinedSegment{segment_, map_.Piece(segment_), moved};
}

Place Odometry::MakePlaceOf(const Window& window, const Keyframe& keyframe) const {
  // Of the points that are to be seen there few may be left in the window: those of keyframes that
  // have retired are among the points of their places.
  std::vector<ReferencePoint> points = MakeReferencePoints(window, keyframe);
  const double offset = DepthOffset(keyframe);
  if (const Place* before = map_.PlaceBefore(segment_, keyframe.id)) {
    const SE3 cam_from_world = keyframe.state.pose() * map_.WorldFromSegment(segment_).Inverse();
    AddSeenPoints(window.camera,
                  *keyframe.frame,
                  offset,
                  PointsSeenFrom(window.camera,
                                 *before,
                                 cam_from_world * map_.CamFromWorld(before->keyframe_id).Inverse()),
                  &points);
  }
  AddMeasuredPoints(window.camera,
                    *keyframe.frame,
                    offset,
                    options_.joining.match.query_points,
                    options_.activation.selection,
                    &points);
  return MakePlace(window.camera, keyframe.id, *keyframe.frame, points);
}

void Odometry::AddStepEdge(const LightFieldFrame& frame, const RecoveryResult& match) {
  const Matrix6d information = PoseInformation(tracker_.reference(),
                                               frame.image,
                                               match.tracking.alignment,
                                               window_.noise,
                                               options_.tracker.alignment);
  const SE3& target_from_reference = match.tracking.alignment.state.target_from_reference;
  map_.AddEdge(
      {match.reference->id,
       next_keyframe_id_,
       target_from_reference,
       EdgeInformation(
           information, target_from_reference, MedianInverseDepth(tracker_.reference().points))});
}

}  // namespace prism
