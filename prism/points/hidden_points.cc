// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/hidden_points.h"

#include "prism/factors/photometric.h"
#include "prism/factors/visibility.h"
#include "prism/image/interpolation.h"

namespace prism {
namespace {

// Small residuals, and most of the pattern's texture is there.
bool IsClearlySeen(const Point& point,
                   const FramePair& pair,
                   const Keyframe& target,
                   const PlenopticProjection& camera,
                   double misfit) {
  constexpr double kMaxRms = 1.5;  // NoiseModel::FitSigma()
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
  return r.squaredNorm() < kMaxRms * kMaxRms * misfit * misfit * kPatternSize &&
         lost < 0.5 * texture;
}

bool IsClippedIn(const Point& point,
                 const FramePair& pair,
                 const Keyframe& target,
                 const PlenopticProjection& camera) {
  constexpr int kCenter = 4;  // of kPattern
  const ImageF& image = target.frame->image[0];
  Eigen::Vector3d x_V;
  if (!ProjectBetweenFrames(
          camera, point.patch.px, point.rho, pair.current.target_from_host, &x_V) ||
      !image.view().Contains(x_V.x(), x_V.y(), kPatternRadius + 2)) {
    return false;
  }
  const double expected =
      pair.current.gain * (point.patch.intensity[kCenter] - pair.current.host_b) + pair.target_b;
  return IsClipped(InterpolateBilinear(image, x_V.x(), x_V.y()).value, expected);
}

}  // namespace

void MarkHiddenPoints(const std::set<int>& misfits, Window* window) {
  const size_t size = window->keyframes.size();
  if (size < 2) return;
  const Keyframe& newest = window->newest();
  const Keyframe& before = *window->keyframes[size - 2];
  for (const auto& host : window->keyframes) {
    if (host->id == newest.id) continue;
    FramePair pair;
    pair.inverse_sigma = 1 / window->noise.ResidualSigma();
    pair.Update(host->state, newest.state);
    for (const auto& point : host->points) {
      const bool is_hidden =
          IsClippedIn(*point, pair, newest, window->camera) || IsHidden(*point, before)
              ? !IsClearlySeen(*point,
                               pair,
                               newest,
                               window->camera,
                               window->noise.FitSigma() / window->noise.ResidualSigma())
              : misfits.count(point->id) > 0;
      if (is_hidden) point->outlier_targets.push_back(newest.id);
    }
  }
}

}  // namespace prism
