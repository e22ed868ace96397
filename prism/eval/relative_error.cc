// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/relative_error.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <glog/logging.h>

namespace prism {
namespace {

// Sums up the errors of pairs (i, j).
class ErrorSum {
 public:
  void Add(const PosePair& from, const PosePair& to) {
    const SE3 truth = from.groundtruth.Inverse() * to.groundtruth;
    const SE3 estimate = from.estimate.Inverse() * to.estimate;
    const SE3 error = truth.Inverse() * estimate;
    const double angle = RotationAngle(error);
    squared_m_ += error.translation().squaredNorm();
    squared_rad_ += angle * angle;
    ++count_;
  }

  std::optional<RelativeError> Result() const {
    if (count_ == 0) return std::nullopt;
    return RelativeError{
        std::sqrt(squared_m_ / count_), std::sqrt(squared_rad_ / count_) * 180 / M_PI, count_};
  }

 private:
  double squared_m_ = 0;
  double squared_rad_ = 0;
  int count_ = 0;
};

}  // namespace

std::optional<RelativeError> RelativeErrorOverTime(const std::vector<PosePair>& poses,
                                                   int64_t interval_ns,
                                                   int64_t tolerance_ns) {
  CHECK_GT(interval_ns, 0);
  ErrorSum sum;
  size_t j = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    const int64_t wanted_ns = poses[i].time_ns + interval_ns;
    const auto distance_ns = [&](size_t k) { return std::abs(poses[k].time_ns - wanted_ns); };
    while (j + 1 < poses.size() && distance_ns(j + 1) <= distance_ns(j)) ++j;
    if (j > i && distance_ns(j) <= tolerance_ns) sum.Add(poses[i], poses[j]);
  }
  return sum.Result();
}

std::optional<RelativeError> RelativeErrorOverDistance(const std::vector<PosePair>& poses,
                                                       double distance_m) {
  CHECK_GT(distance_m, 0);
  const std::vector<double> path_m = GroundtruthPath(poses);
  ErrorSum sum;
  for (size_t i = 0; i < poses.size(); ++i) {
    const auto reached = std::lower_bound(path_m.begin(), path_m.end(), path_m[i] + distance_m);
    if (reached == path_m.end()) break;
    sum.Add(poses[i], poses[static_cast<size_t>(reached - path_m.begin())]);
  }
  return sum.Result();
}

std::vector<double> GroundtruthPath(const std::vector<PosePair>& poses) {
  std::vector<double> path_m(poses.size(), 0.0);
  for (size_t i = 1; i < poses.size(); ++i) {
    path_m[i] =
        path_m[i - 1] +
        (poses[i].groundtruth.translation() - poses[i - 1].groundtruth.translation()).norm();
  }
  return path_m;
}

}  // namespace prism
