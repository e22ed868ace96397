// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/hidden_points.h"

#include "prism/factors/photometric.h"
#include "prism/factors/visibility.h"
#include "prism/image/interpolation.h"

namespace prism {
namespace {

// Small residuals, and most of the pattern's texture is there. `fit_sigma`:
// NoiseModel::WeightedFitSigma.
bool IsClearlySeen(const Point& point,
                   const FramePair& pair,
                   const Keyframe& target,
                   const PlenopticProjection& camera,
                   double fit_sigma) {
  constexpr double kMaxRms = 1.5;  // fit_sigma
  PatternMatch match;
  if (!EvaluatePattern(point.patch, pair, target.frame->image[0], camera, point.rho, &match)) {
    return false;
  }
  const auto& r = match.residuals;
  Eigen::Matrix<double, kPatternSize, 1> expected;
  for (int k = 0; k < kPatternSize; ++k) {
    expected[k] = point.patch.weight[k] * pair.inverse_sigma * pair.current.gain *
                  (point.patch.intensity[k] - point.patch.intensity[0]);
  }
  const double lost = (r.array() - r.mean()).matrix().squaredNorm();
  const double texture = (expected.array() - expected.mean()).matrix().squaredNorm();
  return r.squaredNorm() < kMaxRms * kMaxRms * fit_sigma * fit_sigma * kPatternSize &&
         lost < 0.5 * texture;
}

// IsClipped at the point's pixel.
bool IsClippedIn(const Point& point,
                 const FramePair& pair,
                 const Keyframe& target,
                 const PlenopticProjection& camera) {
  const ImageF& image = target.frame->image[0];
  Eigen::Vector3d x_V;
  if (!ProjectBetweenFrames(
          camera, point.patch.px, point.rho, pair.current.target_from_host, &x_V) ||
      !image.view().Contains(x_V.x(), x_V.y(), kPatternRadius + 2)) {
    return false;
  }
  const double expected =
      pair.current.gain * (point.patch.intensity[kPatternCenter] - pair.current.host_b) +
      pair.target_b;
  return IsClipped(InterpolateBilinear(image, x_V.x(), x_V.y()).value, expected);
}

}  // namespace

void MarkHiddenPoints(const std::set<int>& misfits, Window* window) {
  const size_t size = window->keyframes.size();
  if (size < 2) return;
  const double fit_sigma = window->noise.WeightedFitSigma();
  const Keyframe& newest = window->newest();
  const Keyframe& before = *window->keyframes[size - 2];
  for (const auto& host : window->keyframes) {
    if (host->id == newest.id) continue;
    const FramePair pair = MakeFramePair(window->noise, host->state, newest.state);
    for (const auto& point : host->points) {
      const bool is_doubtful =
          IsHidden(*point, before) || IsClippedIn(*point, pair, newest, window->camera);
      const bool is_hidden = is_doubtful
                                 ? !IsClearlySeen(*point, pair, newest, window->camera, fit_sigma)
                                 : misfits.count(point->id) > 0;
      if (is_hidden) point->outlier_targets.push_back(newest.id);
    }
  }
}

}  // namespace prism
