// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "prism/eval/loop_error.h"
#include "prism/eval/relative_error.h"
#include "prism/geometry/alignment.h"
#include "prism/scene/trajectory.h"

namespace prism {

struct EvaluationOptions {
  // Largest difference in time of a pair in ns; 0: half a frame (see HalfFrame).
  int64_t max_time_difference_ns = 0;
  // Relative errors: over this time in ns, and over these lengths of path in metres.
  int64_t relative_interval_ns = 1000000000;
  std::vector<double> relative_distances_m = {0.25, 0.5, 1, 2, 5, 10, 20, 50, 100};
  // Start and end segment of the loop error, as a fraction of all pairs, 0 to 0.5.
  double loop_segment_fraction = 0.2;
  // Where the estimate begins anew (after tracking was lost), in ns; the first pose is implied.
  std::vector<int64_t> segment_starts_ns;
  // A gap in the estimate longer than this, in ns, begins a new segment too.
  int64_t segment_gap_ns = 1000000000;

  bool IsValid(std::string* error) const;
};

// A piece of the estimate without interruption, aligned to the ground truth by itself.
struct SegmentMetrics {
  int64_t start_ns = 0;
  int64_t end_ns = 0;
  int matched_count = 0;
  double path_length_m = 0;  // of the ground truth
  // Nothing below is set if the segment has fewer than 3 pairs.
  std::optional<double> ate_rmse_m;  // after SE3
  std::optional<double> scale;
};

// What is left after the best Sim3 over all pairs, x_gt = s R x + t (Umeyama).
struct SimilarityError {
  double ate_rmse_m = 0;
  double scale = 1;                // s: the estimate times s has the true size
  double scale_error_percent = 0;  // 100 |ln s|
  double d_s = 1;                  // absolute scale error, max(s, 1/s)
  Sim3 gt_from_estimate;
};

struct DistanceError {
  double distance_m = 0;
  RelativeError error;
};

enum class EvaluationStatus {
  kDone,
  kNoOverlap,      // no pair at all
  kTooFewMatches,  // 1 or 2 pairs
};
// "done", "no overlap in time" or "fewer than 3 matches".
const char* ToString(EvaluationStatus status);

// How far an estimated trajectory is from the true one. Errors are in the units of the ground truth
// (metres); only counts, coverage and path length are set unless status is kDone.
struct TrajectoryMetrics {
  EvaluationStatus status = EvaluationStatus::kNoOverlap;
  int groundtruth_count = 0;
  int estimate_count = 0;
  int matched_count = 0;
  double coverage_percent = 0;  // ground-truth poses with an estimate
  double path_length_m = 0;     // of the whole ground truth

  // Absolute trajectory error: distances |x_gt - T x| left after the best SE3 over all pairs.
  double ate_rmse_m = 0;
  double ate_median_m = 0;
  double ate_max_m = 0;
  SE3 gt_from_estimate;

  std::optional<SimilarityError> sim3;              // nothing: the estimate stands still
  std::optional<RelativeError> relative_over_time;  // nothing: shorter than the interval
  std::vector<DistanceError> relative_over_distance;
  std::optional<LoopError> loop;  // nothing: too short, or no movement at an end
  std::vector<SegmentMetrics> segments;
};

TrajectoryMetrics EvaluateTrajectory(const Trajectory& groundtruth,
                                     const Trajectory& estimate,
                                     const EvaluationOptions& options = {});

}  // namespace prism
