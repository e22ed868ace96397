// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/map.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include <glog/logging.h>

namespace prism {

void Map::Load(const std::vector<MappedPlace>& places) {
  if (places.empty()) return;
  segments_[kLoadedSegment] = {SE3(), kLoadedSegment};
  for (const MappedPlace& known : places) {
    keyframes_[known.place.keyframe_id] = {known.time_ns, kLoadedSegment, known.cam_from_world};
    AddPlace(known.place);
  }
}

void Map::StartSegment(int segment, const SE3& world_from_segment) {
  segments_[segment] = {world_from_segment, segment};
}

void Map::RememberKeyframes(const Window& window, int segment) {
  for (const auto& keyframe : window.keyframes) {
    keyframes_[keyframe->id] = {keyframe->frame->time_ns, segment, keyframe->state.pose()};
  }
}

size_t Map::AddFrame(int64_t time_ns, int keyframe_id, const SE3& cam_from_keyframe) {
  frames_.push_back({time_ns, keyframe_id, cam_from_keyframe});
  return frames_.size() - 1;
}

void Map::MoveFrame(size_t index, const SE3& cam_from_keyframe) {
  frames_.at(index).cam_from_keyframe = cam_from_keyframe;
}

void Map::AddPoints(const std::vector<RetiredPoint>& points) {
  points_.insert(points_.end(), points.begin(), points.end());
}

void Map::AddPlace(Place place) {
  CHECK(keyframes_.count(place.keyframe_id) == 1);
  places_.Add(std::move(place),
              [this](const Place& left, const Place& right) { return PlaceDistance(left, right); });
}

double Map::PlaceDistance(const Place& left, const Place& right) const {
  if (Piece(SegmentOf(left.keyframe_id)) != Piece(SegmentOf(right.keyframe_id))) return INFINITY;
  const SE3 left_from_right =
      CamFromWorld(left.keyframe_id) * CamFromWorld(right.keyframe_id).Inverse();
  return left_from_right.translation().norm() * std::max(left.median_rho, right.median_rho) +
         RotationAngle(left_from_right);
}

SE3 Map::Join(int segment, int onto_piece, const SE3& world_from_segment) {
  const int piece = Piece(segment);
  CHECK(piece != onto_piece && segments_.count(onto_piece) == 1);
  const SE3 new_from_old_world = world_from_segment * WorldFromSegment(segment).Inverse();
  const int name = std::min(piece, onto_piece);
  const SE3 moved = onto_piece < piece ? new_from_old_world : new_from_old_world.Inverse();
  const int moving = std::max(piece, onto_piece);
  for (auto& [number, member] : segments_) {
    if (member.piece != moving) continue;
    member.world_from_segment = moved * member.world_from_segment;
    member.piece = name;
  }
  return moved;
}

SE3 Map::CamFromWorld(int keyframe_id) const {
  const MapKeyframe& keyframe = keyframes_.at(keyframe_id);
  return keyframe.cam_from_segment * WorldFromSegment(keyframe.segment).Inverse();
}

double Map::PathBetween(int first_id, int last_id) const {
  double path = 0;
  const auto end = keyframes_.find(last_id);
  for (auto keyframe = keyframes_.find(first_id); keyframe != end; ++keyframe) {
    const SE3 next_from_this =
        CamFromWorld(std::next(keyframe)->first) * CamFromWorld(keyframe->first).Inverse();
    path += next_from_this.translation().norm();
  }
  return path;
}

std::vector<int> Map::Pieces() const {
  std::set<int> pieces;
  for (const auto& [number, segment] : segments_) {
    if (number != kLoadedSegment) pieces.insert(segment.piece);
  }
  return {pieces.begin(), pieces.end()};
}

std::map<int, int> Map::PieceOfSegments() const {
  std::map<int, int> pieces;
  for (const auto& [number, segment] : segments_) {
    if (number != kLoadedSegment) pieces[number] = segment.piece;
  }
  return pieces;
}

const Place* Map::PlaceBefore(int segment, int keyframe_id) const {
  auto place = places().lower_bound(keyframe_id);
  if (place == places().begin()) return nullptr;
  --place;
  return SegmentOf(place->first) == segment ? &place->second : nullptr;
}

std::vector<MappedPlace> Map::MappedPlaces(int piece) const {
  std::vector<MappedPlace> known;
  for (const auto& [id, place] : places()) {
    const MapKeyframe& keyframe = keyframes_.at(id);
    if (Piece(keyframe.segment) == piece) {
      known.push_back({place, keyframe.time_ns, CamFromWorld(id)});
    }
  }
  return known;
}

Trajectory Map::FrameTrajectory(std::optional<int> piece) const {
  Trajectory trajectory;
  for (const TrackedFrame& frame : frames_) {
    if (piece && Piece(SegmentOf(frame.keyframe_id)) != *piece) continue;
    const SE3 cam_from_world = frame.cam_from_keyframe * CamFromWorld(frame.keyframe_id);
    trajectory.push_back({frame.time_ns, cam_from_world.Inverse()});
  }
  return trajectory;
}

std::vector<int> Map::PiecesOfFrames() const {
  std::vector<int> pieces;
  for (const TrackedFrame& frame : frames_) pieces.push_back(Piece(SegmentOf(frame.keyframe_id)));
  return pieces;
}

Trajectory Map::KeyframeTrajectory() const {
  Trajectory trajectory;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.segment == kLoadedSegment) continue;
    trajectory.push_back({keyframe.time_ns, CamFromWorld(id).Inverse()});
  }
  return trajectory;
}

void Map::ForEachPoint(const Window& window,
                       const std::function<void(const MapPoint&)>& visit) const {
  const auto visit_retired = [&](const RetiredPoint& point) {
    const Eigen::Vector3d x_C = point.x_C.cast<double>();
    visit({CamFromWorld(point.keyframe_id).Inverse() * x_C,
           point.rgb,
           point.keyframe_id,
           point.px.cast<double>(),
           point.rho_sigma * x_C.z() * x_C.norm()});
  };
  for (const RetiredPoint& point : points_) visit_retired(point);
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) {
      visit_retired(MakeRetiredPoint(window.camera, *keyframe, *point));
    }
  }
}

size_t Map::CountPoints(const Window& window) const {
  size_t count = points_.size();
  for (const auto& keyframe : window.keyframes) count += keyframe->points.size();
  return count;
}

std::vector<MapPoint> Map::Points(const Window& window) const {
  std::vector<MapPoint> points;
  points.reserve(CountPoints(window));
  ForEachPoint(window, [&](const MapPoint& point) { points.push_back(point); });
  return points;
}

int Map::CloseLoops() {
  std::map<int, SE3> poses;
  std::vector<int> held;
  std::set<int> pieces_held;
  for (const auto& [id, keyframe] : keyframes_) {
    poses[id] = CamFromWorld(id);
    // A loaded map is not moved, and otherwise the first keyframe of each piece is not.
    const bool is_first = pieces_held.insert(Piece(keyframe.segment)).second;
    if (is_first || keyframe.segment == kLoadedSegment) held.push_back(id);
  }
  std::vector<PoseEdge> edges;
  int loops = 0;
  for (PoseEdge edge : edges_) {
    if (Piece(SegmentOf(edge.from)) != Piece(SegmentOf(edge.to))) continue;
    loops += edge.is_loop;
    // Windows know the pose of a keyframe relative to the one before better than the alignment did
    // that has the information.
    if (!edge.is_loop) edge.to_from_from = poses.at(edge.to) * poses.at(edge.from).Inverse();
    edges.push_back(edge);
  }
  OptimizePoses(edges, held, &poses);
  for (auto& [id, keyframe] : keyframes_) {
    keyframe.cam_from_segment = poses.at(id) * WorldFromSegment(keyframe.segment);
  }
  return loops;
}

}  // namespace prism
