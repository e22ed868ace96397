// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/outliers.h"

#include <algorithm>
#include <cmath>

#include "prism/base/stage_timer.h"
#include "prism/residual/photometric.h"
#include "prism/window/pair_table.h"

namespace prism {
namespace {

struct Observation {
  Point* point;
  double rms;
};

}  // namespace

OutlierResult RemoveOutliers(const WindowOptions& window_options,
                             const OutlierOptions& options,
                             Window* window) {
  OutlierResult result;
  const PairTable pairs(*window, false);
  auto& keyframes = window->keyframes;
  std::vector<std::vector<bool>> had_observation(keyframes.size());
  for (size_t i = 0; i < keyframes.size(); ++i) {
    had_observation[i].assign(keyframes[i]->points.size(), false);
  }
  for (size_t j = 0; j < keyframes.size(); ++j) {
    const Keyframe& target = *keyframes[j];
    std::vector<Observation> observations;
    for (size_t i = 0; i < keyframes.size(); ++i) {
      if (i == j) continue;
      for (size_t p = 0; p < keyframes[i]->points.size(); ++p) {
        Point& point = *keyframes[i]->points[p];
        if (!IsObserved(*window, *keyframes[i], point, target)) continue;
        had_observation[i][p] = true;
        const PhotometricCost cost(
            &point.patch, &pairs.pair(i, j), target.frame->image[0], &window->camera);
        const double* parameters[] = {keyframes[i]->state.data(), target.state.data(), &point.rho};
        Eigen::Matrix<double, kPatternSize, 1> r;
        cost.Evaluate(parameters, r.data(), nullptr);
        observations.push_back({&point, r.norm() / std::sqrt(double{kPatternSize})});
      }
    }
    std::vector<double> rms;
    for (const Observation& observation : observations) rms.push_back(observation.rms);
    const double threshold =
        0.5 * (options.base_rms + options.quantile_factor * Quantile(rms, options.quantile));
    for (const Observation& observation : observations) {
      if (observation.rms <= threshold) continue;
      observation.point->outlier_targets.push_back(target.id);
      ++result.observations_dropped;
    }
  }
  for (size_t i = 0; i < keyframes.size(); ++i) {
    auto& points = keyframes[i]->points;
    size_t kept = 0;
    for (size_t p = 0; p < points.size(); ++p) {
      Point& point = *points[p];
      bool is_observed = false;
      for (size_t j = 0; j < keyframes.size() && !is_observed; ++j) {
        is_observed = i != j && IsObserved(*window, *keyframes[i], point, *keyframes[j]);
      }
      if ((had_observation[i][p] && !is_observed) || !(point.rho > 0) ||
          !(point.rho * window->camera.f < 1)) {
        ++result.points_dropped;
        continue;
      }
      if (point.w_sigma > 0 && is_observed) {
        const double r =
            (InverseVirtualDepth(window->camera, point.rho) - point.w_measured) / point.w_sigma;
        if (std::abs(r) > window_options.depth_outlier) {
          point.w_sigma = 0;
          ++result.depth_measurements_dropped;
        }
      }
      if (kept != p) points[kept] = std::move(points[p]);
      ++kept;
    }
    points.resize(kept);
  }
  return result;
}

}  // namespace prism
