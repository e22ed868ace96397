// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/metrics.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>

#include "prism/base/statistics.h"

namespace prism {
namespace {

double PathLength(const Trajectory& trajectory) {
  double length = 0;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].world_from_cam.translation() -
               trajectory[i - 1].world_from_cam.translation())
                  .norm();
  }
  return length;
}

std::optional<SimilarityError> ComputeSimilarityError(const std::vector<Eigen::Vector3d>& estimate,
                                                      const std::vector<Eigen::Vector3d>& truth) {
  const AlignmentResult alignment = AlignPoints(estimate, truth, true);
  if (!alignment.success) return std::nullopt;
  SimilarityError error;
  const double s = alignment.target_from_source.scale;
  error.ate_rmse_m = alignment.rmse;
  error.scale = s;
  error.scale_error_percent = 100 * std::abs(std::log(s));
  error.d_s = std::max(s, 1 / s);
  error.gt_from_estimate = alignment.target_from_source;
  return error;
}

void ComputeAbsoluteError(const std::vector<PosePair>& pairs, TrajectoryMetrics* metrics) {
  const std::vector<Eigen::Vector3d> truth = GroundtruthPositions(pairs);
  const std::vector<Eigen::Vector3d> estimate = EstimatePositions(pairs);
  const AlignmentResult alignment = AlignPoints(estimate, truth, false);
  if (!alignment.success) {
    metrics->status = EvaluationStatus::kTooFewMatches;
    return;
  }
  metrics->status = EvaluationStatus::kDone;
  metrics->gt_from_estimate = alignment.target_from_source.rigid;
  metrics->ate_rmse_m = alignment.rmse;
  std::vector<double> distances;
  for (size_t i = 0; i < pairs.size(); ++i) {
    distances.push_back((truth[i] - metrics->gt_from_estimate * estimate[i]).norm());
  }
  metrics->ate_max_m = *std::max_element(distances.begin(), distances.end());
  metrics->ate_median_m = Quantile(std::move(distances), 0.5);
  metrics->sim3 = ComputeSimilarityError(estimate, truth);
}

// Times at which a segment of the estimate begins, in order, each once.
std::vector<int64_t> SegmentStarts(const Trajectory& estimate, const EvaluationOptions& options) {
  std::vector<int64_t> starts = options.segment_starts_ns;
  starts.push_back(estimate.front().time_ns);
  for (size_t i = 1; i < estimate.size(); ++i) {
    if (estimate[i].time_ns - estimate[i - 1].time_ns > options.segment_gap_ns) {
      starts.push_back(estimate[i].time_ns);
    }
  }
  std::sort(starts.begin(), starts.end());
  starts.erase(std::unique(starts.begin(), starts.end()), starts.end());
  return starts;
}

SegmentMetrics EvaluateSegment(const std::vector<PosePair>& pairs) {
  SegmentMetrics segment;
  segment.matched_count = static_cast<int>(pairs.size());
  if (pairs.empty()) return segment;
  segment.start_ns = pairs.front().time_ns;
  segment.end_ns = pairs.back().time_ns;
  segment.path_length_m = GroundtruthPath(pairs).back();
  const std::vector<Eigen::Vector3d> truth = GroundtruthPositions(pairs);
  const std::vector<Eigen::Vector3d> estimate = EstimatePositions(pairs);
  const AlignmentResult se3 = AlignPoints(estimate, truth, false);
  const AlignmentResult sim3 = AlignPoints(estimate, truth, true);
  if (se3.success) segment.ate_rmse_m = se3.rmse;
  if (sim3.success) segment.scale = sim3.target_from_source.scale;
  return segment;
}

std::vector<SegmentMetrics> EvaluateSegments(const std::vector<PosePair>& pairs,
                                             const std::vector<int64_t>& starts_ns) {
  std::vector<SegmentMetrics> segments;
  const auto lower = [&](int64_t time_ns) {
    return std::partition_point(
        pairs.begin(), pairs.end(), [&](const PosePair& pair) { return pair.time_ns < time_ns; });
  };
  for (size_t i = 0; i < starts_ns.size(); ++i) {
    const auto begin = lower(starts_ns[i]);
    const auto end = i + 1 < starts_ns.size() ? lower(starts_ns[i + 1]) : pairs.end();
    if (begin < end) segments.push_back(EvaluateSegment(std::vector<PosePair>(begin, end)));
  }
  return segments;
}

}  // namespace

bool EvaluationOptions::IsValid(std::string* error) const {
  const auto fail = [&](const char* message) {
    *error = message;
    return false;
  };
  if (max_time_difference_ns < 0) return fail("max_time_difference_ns is negative");
  if (relative_interval_ns <= 0) return fail("relative_interval_ns is not positive");
  for (const double distance : relative_distances_m) {
    if (!(distance > 0)) return fail("relative_distances_m has a length that is not positive");
  }
  if (!(loop_segment_fraction >= 0 && loop_segment_fraction <= 0.5)) {
    return fail("loop_segment_fraction is not in 0 to 0.5");
  }
  if (segment_gap_ns <= 0) return fail("segment_gap_ns is not positive");
  return true;
}

const char* ToString(EvaluationStatus status) {
  switch (status) {
    case EvaluationStatus::kDone:
      return "done";
    case EvaluationStatus::kNoOverlap:
      return "no overlap in time";
    case EvaluationStatus::kTooFewMatches:
      return "fewer than 3 matches";
  }
  return "";
}

TrajectoryMetrics EvaluateTrajectory(const Trajectory& groundtruth,
                                     const Trajectory& estimate,
                                     const EvaluationOptions& options) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  TrajectoryMetrics metrics;
  metrics.groundtruth_count = static_cast<int>(groundtruth.size());
  metrics.estimate_count = static_cast<int>(estimate.size());
  metrics.path_length_m = PathLength(groundtruth);
  if (groundtruth.empty() || estimate.empty()) return metrics;

  const int64_t tolerance_ns = options.max_time_difference_ns > 0
                                   ? options.max_time_difference_ns
                                   : HalfFrame(groundtruth, estimate);
  const std::vector<PosePair> pairs = Associate(groundtruth, estimate, tolerance_ns);
  metrics.matched_count = static_cast<int>(pairs.size());
  metrics.coverage_percent =
      100.0 * CountCovered(groundtruth, estimate, tolerance_ns) / metrics.groundtruth_count;
  if (pairs.empty()) return metrics;

  ComputeAbsoluteError(pairs, &metrics);
  if (metrics.status != EvaluationStatus::kDone) return metrics;
  metrics.relative_over_time =
      RelativeErrorOverTime(pairs, options.relative_interval_ns, tolerance_ns);
  for (const double distance_m : options.relative_distances_m) {
    const auto relative = RelativeErrorOverDistance(pairs, distance_m);
    if (relative) metrics.relative_over_distance.push_back({distance_m, *relative});
  }
  metrics.loop = ComputeLoopError(
      pairs,
      estimate,
      static_cast<int>(options.loop_segment_fraction * static_cast<double>(pairs.size())));
  metrics.segments = EvaluateSegments(pairs, SegmentStarts(estimate, options));
  return metrics;
}

}  // namespace prism
