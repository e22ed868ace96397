// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/joining.h"

#include <algorithm>
#include <array>

#include "prism/base/statistics.h"
#include "prism/geometry/alignment.h"

namespace prism {
namespace {

// Whether two placements put a keyframe at the same place, as far as a segment that is right by
// itself, or nearly so, can tell.
bool Agree(const JoiningOptions& options,
           const SegmentPlacement& left,
           const SegmentPlacement& right,
           const TrackingReference& reference) {
  if (left.onto_piece != right.onto_piece) return false;
  const SE3 left_from_right = left.cam_from_segment * left.world_from_segment.Inverse() *
                              right.world_from_segment * left.cam_from_segment.Inverse();
  const double motion =
      FlowBetween(reference, SE3(), left.cam_from_segment * right.cam_from_segment.Inverse());
  const double limit = options.max_flow * reference.cameras[0].width;
  return FlowBetween(reference, SE3(), left_from_right) <=
         std::min(limit + options.max_flow_of_motion * motion, 4 * limit);
}

// A camera, and points a view's width apart that it sees.
std::array<Eigen::Vector3d, 5> ViewPoints(double depth) {
  const double side = depth / 3;
  return {{{0, 0, 0},
           {side, side, depth},
           {-side, side, depth},
           {side, -side, depth},
           {-side, -side, depth}}};
}

}  // namespace

bool JoiningOptions::IsValid(std::string* error) const {
  if (!match.IsValid(error)) return false;
  if (max_places >= 2 && min_agreeing >= 1 && max_flow > 0 && max_flow_of_motion >= 0 &&
      settling_keyframes >= 0 && min_loop_keyframes >= 0 && max_loop_drift > 0 &&
      max_loop_offset_m > 0 && max_loop_rotation > 0) {
    return true;
  }
  *error =
      "joining needs 2 places and a keyframe that agrees or more, and positive limits of what may "
      "differ";
  return false;
}

std::optional<SegmentPlacement> SegmentJoiner::Observe(const JoiningOptions& options,
                                                       const std::vector<SegmentPlacement>& matches,
                                                       const TrackingReference& reference) {
  if (matches.empty()) return std::nullopt;
  const auto agrees = [&](const SegmentPlacement& left, const SegmentPlacement& right) {
    return Agree(options, left, right, reference);
  };
  const SegmentPlacement& newest = matches.front();
  const bool is_clear = std::all_of(
      matches.begin(), matches.end(), [&](const auto& other) { return agrees(newest, other); });
  placements_.push_back(is_clear ? std::optional(newest) : std::nullopt);
  if (placements_.size() > kRemembered) placements_.erase(placements_.begin());
  if (!is_clear) return std::nullopt;
  Vector6d mean = Vector6d::Zero();  // of those that agree, from `newest`
  int agreeing = 0;
  for (const std::optional<SegmentPlacement>& placement : placements_) {
    if (!placement || !agrees(newest, *placement)) continue;
    ++agreeing;
    mean += (placement->world_from_segment * newest.world_from_segment.Inverse()).Log();
  }
  const int contradicting = static_cast<int>(placements_.size()) - agreeing;
  if (agreeing < options.min_agreeing || agreeing <= 2 * contradicting) return std::nullopt;
  return SegmentPlacement{newest.onto_piece,
                          SE3::Exp(mean / agreeing) * newest.world_from_segment,
                          newest.cam_from_segment};
}

std::optional<SE3> FitSegment(const Map& map, int segment, const std::vector<Sighting>& sightings) {
  constexpr size_t kLeast = 3;
  constexpr double kOutlier = 3;  // medians
  if (sightings.size() < kLeast) return std::nullopt;
  const auto segment_from_cam = [&](const Sighting& sighting) {
    return (map.CamFromWorld(sighting.keyframe_id) * map.WorldFromSegment(segment)).Inverse();
  };
  const auto fit = [&](const std::vector<const Sighting*>& used) {
    std::vector<Eigen::Vector3d> in_segment, in_world;
    for (const Sighting* sighting : used) {
      for (const Eigen::Vector3d& p_in_cam : ViewPoints(sighting->depth)) {
        in_segment.push_back(segment_from_cam(*sighting) * p_in_cam);
        in_world.push_back(sighting->cam_from_world.Inverse() * p_in_cam);
      }
    }
    return AlignPoints(in_segment, in_world, false).target_from_source.rigid;
  };
  const auto distance = [&](const Sighting& sighting, const SE3& world_from_segment) {
    const SE3 shift = sighting.cam_from_world * world_from_segment * segment_from_cam(sighting);
    double sum = 0;
    for (const Eigen::Vector3d& p_in_cam : ViewPoints(sighting.depth)) {
      sum += (shift * p_in_cam - p_in_cam).norm();
    }
    return sum;
  };
  std::vector<const Sighting*> used;
  for (const Sighting& sighting : sightings) used.push_back(&sighting);
  const SE3 first = fit(used);
  std::vector<double> distances;
  for (const Sighting& sighting : sightings) distances.push_back(distance(sighting, first));
  const double limit = kOutlier * Quantile(distances, 0.5);
  used.clear();
  for (size_t i = 0; i < sightings.size(); ++i) {
    if (distances[i] <= limit) used.push_back(&sightings[i]);
  }
  return used.size() < kLeast ? std::nullopt : std::optional(fit(used));
}

bool IsPlausibleLoop(const JoiningOptions& options,
                     const Map& map,
                     const PlaceMatch& match,
                     int keyframe_id) {
  const SE3 expected =
      map.CamFromWorld(keyframe_id) * map.CamFromWorld(match.keyframe_id).Inverse();
  const SE3 drift = match.query_from_known * expected.Inverse();
  return drift.translation().norm() <=
             options.max_loop_offset_m +
                 options.max_loop_drift * map.PathBetween(match.keyframe_id, keyframe_id) &&
         RotationAngle(drift) <= options.max_loop_rotation;
}

SegmentPlacement PlaceSegment(const Map& map,
                              const PlaceMatch& match,
                              const SE3& cam_from_segment) {
  const SE3 cam_from_world = match.query_from_known * map.CamFromWorld(match.keyframe_id);
  return {map.Piece(map.SegmentOf(match.keyframe_id)),
          cam_from_world.Inverse() * cam_from_segment,
          cam_from_segment};
}

}  // namespace prism
