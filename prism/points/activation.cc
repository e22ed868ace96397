// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/activation.h"

#include <algorithm>
#include <cmath>

#include "prism/factors/visibility.h"
#include "prism/points/shared_depths.h"

namespace prism {
namespace {

// False if most of the depths measured around a pixel contradict its own. At the edge of a thing
// half of them do.
bool IsSupported(const LightFieldFrame& frame, int x, int y) {
  constexpr int kRadius = 2;              // px
  constexpr int kMinMeasured = 5;         // fewer say nothing
  constexpr double kMaxDifference = 3.5;  // standard deviations
  constexpr double kMinAgreeing = 0.35;
  const double w = frame.inverse_virtual_depth(x, y), sigma = frame.sigma(x, y);
  int measured = 0, agreeing = 0;
  for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, frame.sigma.height() - 1);
       ++v) {
    for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, frame.sigma.width() - 1);
         ++u) {
      const double other = frame.sigma(u, v);
      if (other == 0 || (u == x && v == y)) continue;
      ++measured;
      agreeing += std::abs(frame.inverse_virtual_depth(u, v) - w) <
                  kMaxDifference * std::hypot(sigma, other);
    }
  }
  return measured < kMinMeasured || agreeing >= kMinAgreeing * measured;
}

int NumObserved(const Window& window, const Keyframe& target) {
  int count = 0;
  for (const auto& host : window.keyframes) {
    for (const auto& point : host->points) {
      count += host->id == target.id || IsObserved(window, *host, *point, target);
    }
  }
  return count;
}

}  // namespace

bool ActivationOptions::IsValid(std::string* error) const {
  if (!selection.IsValid(error) || !candidates.IsValid(error) || !refinement.IsValid(error)) {
    return false;
  }
  if (max_new_points >= 1 && min_point_distance >= 1 && micro_image_gradient_margin >= 0) {
    return true;
  }
  *error =
      "activation needs a point or more, a distance of 1 px or more and a gradient margin of 0 or "
      "more";
  return false;
}

void ActivatePoints(const ActivationOptions& options,
                    const TermList& terms,
                    int max_points,
                    Window* window) {
  const size_t newest_index = window->keyframes.size() - 1;
  Keyframe& newest = window->newest();
  const LightFieldFrame& frame = *newest.frame;
  CoverageMap coverage(*window);
  DepthRefiner refiner(*window, terms, options.refinement);
  // Points it does not see must not keep it from having some of its own.
  const int seen = NumObserved(*window, newest);
  int room = std::max(max_points - window->NumPoints(), max_points / 2 - seen);
  if (newest_index > 0) {
    room = std::min(room, options.max_new_points);
    room -= ActivateCandidates(
        options.candidates, options.min_point_distance, room, &refiner, &coverage, window);
  }
  PointSelectionOptions selection = options.selection;
  if (frame.depth_correlation_px > 0) {
    selection.gradient_margin = options.micro_image_gradient_margin;
  }
  const ImageF squared_gradient = SquaredGradientMagnitude(frame.image[0]);
  const auto select = [&](int count, bool with_depth) {
    const auto is_usable = [&](int x, int y) {
      return (frame.sigma(x, y) > 0) == with_depth &&
             coverage.IsFree(x, y, options.min_point_distance) &&
             (!with_depth || IsSupported(frame, x, y));
    };
    return SelectPoints(squared_gradient, count, is_usable, selection);
  };
  Candidate candidate;
  const std::vector<Eigen::Vector2i> measured = select(room, /*with_depth=*/true);
  const std::vector<double> sharing = NumSharingDepth(measured, frame.depth_correlation_px);
  for (size_t i = 0; i < measured.size(); ++i) {
    if (MakeCandidate(*window, options.candidates, newest, measured[i], &candidate)) {
      candidate.w_sigma *= std::sqrt(sharing[i]);
      ActivateCandidate(newest_index, candidate, &refiner, window);
    }
  }
  // Where nothing was measured, motion alone has to tell.
  for (const Eigen::Vector2i& px :
       select(options.candidates.max_per_keyframe, /*with_depth=*/false)) {
    if (MakeCandidate(*window, options.candidates, newest, px, &candidate)) {
      newest.candidates.push_back(candidate);
    }
  }
}

}  // namespace prism
