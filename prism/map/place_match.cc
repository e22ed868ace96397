// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_match.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prism/base/statistics.h"
#include "prism/image/interpolation.h"
#include "prism/map/place_features.h"
#include "prism/map/place_points.h"
#include "prism/map/place_view.h"
#include "prism/tracking/depth_agreement.h"

namespace prism {
namespace {

// ln of what the target's intensities are times the reference's, at a pose that is roughly right.
double LogGain(const TrackingReference& reference,
               const ImagePyramid& target,
               const SE3& target_from_reference) {
  constexpr double kDark = 5, kBright = 250;
  const size_t level = std::min<size_t>({2, reference.levels.size() - 1, target.size() - 1});
  const PlenopticProjection& camera = reference.cameras[level];
  const RigidMotion motion(target_from_reference);
  std::vector<double> gains;
  ForEachPixel(reference.levels[level], [&](const ReferencePixel& pixel, size_t index) {
    const ReferencePoint& point = reference.points[index];
    const Eigen::Vector2d px =
        (point.px.array() + 0.5) * std::ldexp(1.0, -static_cast<int>(level)) - 0.5;
    Eigen::Vector3d x_V;
    if (!ProjectBetweenFrames(camera, px, point.rho, motion, &x_V) ||
        !target[level].view().Contains(x_V.x(), x_V.y(), 1)) {
      return;
    }
    const double now = InterpolateBilinear(target[level], x_V.x(), x_V.y()).value;
    const double before = pixel.intensity;
    if (std::min(now, before) > kDark && std::max(now, before) < kBright) {
      gains.push_back(std::log(now / before));
    }
  });
  return gains.empty() ? 0 : Quantile(gains, 0.5);
}

FrameAlignmentResult AlignFrom(const TrackingReference& reference,
                               const ImagePyramid& target,
                               const SE3& start,
                               const NoiseModel& noise,
                               const AlignmentOptions& options) {
  AlignmentState state;
  state.target_from_reference = start;
  state.a = LogGain(reference, target, start);
  return AlignFrame(reference, target, state, noise, options);
}

}  // namespace

bool PlaceMatchOptions::IsValid(std::string* error) const {
  if (query_points >= 50 && min_matches >= 4 && max_candidates >= 1 && min_inliers >= 4 &&
      max_disagreement > 0) {
    return there.IsValid(error) && back.IsValid(error);
  }
  *error =
      "finding places needs 50 points, 4 matches and inliers and a candidate or more, and a "
      "positive limit of what alignments there and back may differ by";
  return false;
}

PlaceQuery MakePlaceQuery(const PlenopticCamera& camera,
                          const LightFieldFrame& frame,
                          const PointSelectionOptions& selection,
                          const PlaceMatchOptions& options) {
  const PlenopticProjection projection(camera);
  std::vector<ReferencePoint> points;
  AddMeasuredPoints(projection, frame, 0, options.query_points, selection, &points);
  PlaceQuery query{frame, {}, MakeTrackingReference(camera, frame.image, points)};
  query.place.median_rho = static_cast<float>(MedianInverseDepth(points));
  DetectFeatures(projection, frame, &query.place);
  return query;
}

std::optional<PlaceMatch> VerifyMatch(const PlenopticCamera& camera,
                                      const Place& place,
                                      const PlaceQuery& query,
                                      const SE3& start,
                                      const NoiseModel& noise,
                                      double depth_offset,
                                      const AlignmentOptions& alignment,
                                      const PlaceMatchOptions& options) {
  const PlaceView known = MakePlaceView(camera, place);
  const auto check_depth = MakeDepthCheck(noise, query.frame, depth_offset, 0);
  FrameAlignmentResult there =
      AlignFrom(known.reference, query.frame.image, start, noise, alignment);
  if (there.status != AlignmentStatus::kGood) return std::nullopt;
  there.fit.depth_agreement = check_depth(known.reference, there);
  if (!options.there.AreMetBy(there.fit)) return std::nullopt;
  const SE3& query_from_known = there.state.target_from_reference;
  const FrameAlignmentResult back =
      AlignFrom(query.reference, known.image, query_from_known.Inverse(), noise, alignment);
  if (back.status != AlignmentStatus::kGood || !options.back.AreMetBy(back.fit))
    return std::nullopt;
  if (FlowBetween(known.reference, query_from_known, back.state.target_from_reference.Inverse()) >
      options.max_disagreement * camera.focused_width()) {
    return std::nullopt;
  }
  PlaceMatch match;
  match.keyframe_id = place.keyframe_id;
  match.query_from_known = query_from_known;
  match.information = PoseInformation(known.reference, query.frame.image, there, noise, alignment);
  return match;
}

std::vector<PlaceMatch> FindMatches(const PlenopticCamera& camera,
                                    const std::vector<const Place*>& places,
                                    const PlaceQuery& query,
                                    const NoiseModel& noise,
                                    double depth_offset,
                                    const AlignmentOptions& alignment,
                                    const PlaceMatchOptions& options) {
  struct Candidate {
    const Place* place;
    std::vector<FeatureMatch> matches;
  };
  std::vector<Candidate> candidates;
  for (const Place* place : places) {
    std::vector<FeatureMatch> matches = MatchFeatures(query.place, *place);
    if (static_cast<int>(matches.size()) < options.min_matches) continue;
    candidates.push_back({place, std::move(matches)});
  }
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const Candidate& left, const Candidate& right) {
        return left.matches.size() > right.matches.size();
      });
  if (static_cast<int>(candidates.size()) > options.max_candidates) {
    candidates.resize(options.max_candidates);
  }
  const PlenopticProjection projection(camera);
  std::vector<PlaceMatch> found;
  for (const Candidate& candidate : candidates) {
    const std::optional<FeaturePose> pose = EstimateFeaturePose(
        projection, query.place, *candidate.place, candidate.matches, options.min_inliers);
    if (!pose) continue;
    std::optional<PlaceMatch> match = VerifyMatch(camera,
                                                  *candidate.place,
                                                  query,
                                                  pose->query_from_known,
                                                  noise,
                                                  depth_offset,
                                                  alignment,
                                                  options);
    if (!match) continue;
    match->feature_inliers = pose->inliers;
    found.push_back(*match);
  }
  std::stable_sort(found.begin(), found.end(), [](const PlaceMatch& left, const PlaceMatch& right) {
    return left.feature_inliers > right.feature_inliers;
  });
  return found;
}

}  // namespace prism
