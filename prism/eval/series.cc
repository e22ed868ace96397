// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/series.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>

#include "prism/geometry/alignment.h"

namespace prism {
namespace {

double Spread(const std::vector<Eigen::Vector3d>& points) {
  const auto count = static_cast<double>(points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) mean += point / count;
  double sum = 0;
  for (const Eigen::Vector3d& point : points) sum += (point - mean).squaredNorm();
  return std::sqrt(sum / count);
}

}  // namespace

std::vector<TimedValue> ErrorOverTime(const std::vector<PosePair>& pairs,
                                      const SE3& gt_from_estimate) {
  std::vector<TimedValue> series;
  series.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d aligned = gt_from_estimate * pair.estimate.translation();
    series.push_back({pair.time_ns, (pair.groundtruth.translation() - aligned).norm()});
  }
  return series;
}

std::vector<TimedValue> ScaleOverTime(const std::vector<PosePair>& pairs,
                                      const ScaleSeriesOptions& options) {
  CHECK_GT(options.max_count, 0);
  std::vector<TimedValue> series;
  const size_t step = std::max<size_t>(1, pairs.size() / static_cast<size_t>(options.max_count));
  const auto before = [](const PosePair& pair, int64_t time_ns) { return pair.time_ns < time_ns; };
  for (size_t i = 0; i < pairs.size(); i += step) {
    const int64_t time_ns = pairs[i].time_ns;
    const auto begin =
        std::lower_bound(pairs.begin(), pairs.end(), time_ns - options.window_ns / 2, before);
    const auto end = std::lower_bound(begin, pairs.end(), time_ns + options.window_ns / 2, before);
    const std::vector<PosePair> window(begin, end);
    if (window.size() < 3) continue;
    const std::vector<Eigen::Vector3d> truth = GroundtruthPositions(window);
    if (Spread(truth) < options.min_spread_m) continue;
    const AlignmentResult alignment = AlignPoints(EstimatePositions(window), truth, true);
    if (alignment.success) series.push_back({time_ns, alignment.target_from_source.scale});
  }
  return series;
}

}  // namespace prism
