// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "prism/map/place_store.h"
#include "prism/map/pose_graph.h"
#include "prism/scene/trajectory.h"
#include "prism/window/retirement.h"

namespace prism {

// A scene point in metres with its colour, gray where frames have none.
struct MapPoint {
  Eigen::Vector3d p_in_world = Eigen::Vector3d::Zero();
  std::array<uint8_t, 3> rgb{};
  int keyframe_id = 0;                           // its host
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // there, focused px
  double sigma_m = 0;  // of its depth in the host, along the ray; 0: not known
};

// The segment of what was known before the run.
inline constexpr int kLoadedSegment = -1;

// What the odometry has found so far: poses of keyframes as they were when the window last held
// them, the frames that were tracked on them, the points that have left the window, and places to
// be found again.
//
// Each segment of the run has coordinates of its own, those of its first camera, and a place in the
// world. Segments that are known relative to each other form one piece, named by the smallest of
// their numbers; a piece moves as a whole when it is joined to another. The world is that of piece
// 0, or of the loaded segment once piece 0 is joined to it; pieces that are not joined yet stand
// where they were assumed to start.
class Map {
 public:
  explicit Map(int max_places) : places_(max_places) {}

  // Places known before the run. Their keyframes are not part of its trajectories.
  void Load(const std::vector<MappedPlace>& places);

  bool HasLoadedPlaces() const { return segments_.count(kLoadedSegment) > 0; }

  void StartSegment(int segment, const SE3& world_from_segment);
  // To be called whenever the window's keyframes, all of one segment, have moved.
  void RememberKeyframes(const Window& window, int segment);
  // A frame tracked on a keyframe; a keyframe itself with the identity. Returns its index.
  size_t AddFrame(int64_t time_ns, int keyframe_id, const SE3& cam_from_keyframe);
  // Its pose relative to its keyframe is known better.
  void MoveFrame(size_t index, const SE3& cam_from_keyframe);
  void AddPoints(const std::vector<RetiredPoint>& points);
  // Of a keyframe that is known.
  void AddPlace(Place place);
  // What was measured between two keyframes that are known, for CloseLoops.
  void AddEdge(const PoseEdge& edge) { edges_.push_back(edge); }

  // Joins the piece of a segment to another, in whose world it stands as given: the one that began
  // later is moved. Returns new from old world coordinates of what was.
  SE3 Join(int segment, int onto_piece, const SE3& world_from_segment);

  // A segment has to be elsewhere in the world of its piece.
  void PlaceSegment(int segment, const SE3& world_from_segment) {
    segments_.at(segment).world_from_segment = world_from_segment;
  }

  int Piece(int segment) const { return segments_.at(segment).piece; }
  const SE3& WorldFromSegment(int segment) const {
    return segments_.at(segment).world_from_segment;
  }
  int SegmentOf(int keyframe_id) const { return keyframes_.at(keyframe_id).segment; }
  SE3 CamFromWorld(int keyframe_id) const;
  // Length of the way from keyframe to keyframe in the world, m.
  double PathBetween(int first_id, int last_id) const;
  int LastKeyframeId() const { return keyframes_.empty() ? -1 : keyframes_.rbegin()->first; }
  // Of the run, in the order they began; and the piece of each segment.
  std::vector<int> Pieces() const;
  std::map<int, int> PieceOfSegments() const;

  const std::map<int, Place>& places() const { return places_.places(); }
  // Of a segment, the one with the next smaller number than a keyframe; nullptr: there is none.
  const Place* PlaceBefore(int segment, int keyframe_id) const;
  // The places of the piece of a segment in the world, to be kept for a later run.
  std::vector<MappedPlace> MappedPlaces(int piece) const;

  // All tracked frames, each carried by the last pose of the keyframe it was tracked on; of all
  // pieces or of one.
  Trajectory FrameTrajectory(std::optional<int> piece = std::nullopt) const;
  // The piece of each of all tracked frames.
  std::vector<int> PiecesOfFrames() const;
  Trajectory KeyframeTrajectory() const;
  // Calls visit(point) with the points that left the window and those in it, by the last poses of
  // their keyframes.
  void ForEachPoint(const Window& window, const std::function<void(const MapPoint&)>& visit) const;
  size_t CountPoints(const Window& window) const;
  std::vector<MapPoint> Points(const Window& window) const;

  // The keyframes moved to where all edges say they are, each piece in its world (OptimizePoses);
  // frames and points follow their keyframes. Returns the number of edges that are not between a
  // keyframe and its predecessor.
  int CloseLoops();

 private:
  struct Segment {
    SE3 world_from_segment;
    int piece = 0;
  };
  struct MapKeyframe {
    int64_t time_ns = 0;
    int segment = 0;
    SE3 cam_from_segment;
  };
  struct TrackedFrame {
    int64_t time_ns;
    int keyframe_id;
    SE3 cam_from_keyframe;
  };
  double PlaceDistance(const Place& left, const Place& right) const;

  std::map<int, Segment> segments_;
  std::map<int, MapKeyframe> keyframes_;  // by id
  std::vector<TrackedFrame> frames_;
  std::deque<RetiredPoint> points_;  // no room is kept for more
  std::vector<PoseEdge> edges_;
  PlaceStore places_;
};

}  // namespace prism
