// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/loop_error.h"

#include <algorithm>
#include <cmath>

#include "prism/geometry/alignment.h"

namespace prism {
namespace {

AlignmentResult AlignSegment(const std::vector<PosePair>& pairs, size_t first, size_t size) {
  const auto begin = pairs.begin() + static_cast<std::ptrdiff_t>(first);
  const std::vector<PosePair> segment(begin, begin + static_cast<std::ptrdiff_t>(size));
  return AlignPoints(EstimatePositions(segment), GroundtruthPositions(segment), true);
}

}  // namespace

std::optional<LoopError> ComputeLoopError(const std::vector<PosePair>& pairs,
                                          const Trajectory& estimate,
                                          int segment_size) {
  if (segment_size < 3 || pairs.size() < 2 * static_cast<size_t>(segment_size)) return std::nullopt;
  const auto size = static_cast<size_t>(segment_size);
  const AlignmentResult start = AlignSegment(pairs, 0, size);
  const AlignmentResult end = AlignSegment(pairs, pairs.size() - size, size);
  if (!start.success || !end.success) return std::nullopt;

  const Sim3& gt_from_start = start.target_from_source;
  const Sim3& gt_from_end = end.target_from_source;
  LoopError error;
  error.scale_start = gt_from_start.scale;
  error.scale_end = gt_from_end.scale;
  error.e_s = std::max(error.scale_start / error.scale_end, error.scale_end / error.scale_start);
  error.e_r_deg =
      gt_from_start.rigid.rotation().angularDistance(gt_from_end.rigid.rotation()) * 180 / M_PI;
  double sum = 0;
  for (const StampedPose& pose : estimate) {
    const Eigen::Vector3d position = pose.world_from_cam.translation();
    sum += (gt_from_start * position - gt_from_end * position).squaredNorm();
  }
  error.e_align_m = std::sqrt(sum / static_cast<double>(estimate.size()));
  return error;
}

}  // namespace prism
