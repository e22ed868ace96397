// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/activation.h"

#include <algorithm>
#include <cmath>

#include "prism/factors/visibility.h"
#include "prism/points/depth_support.h"
#include "prism/points/shared_depths.h"

namespace prism {
namespace {

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
  DepthSupport support(window->camera, frame);
  const ImageF squared_gradient = SquaredGradientMagnitude(frame.image[0]);
  const auto select = [&](int count, bool with_depth) {
    const auto is_usable = [&](int x, int y) {
      return (frame.sigma(x, y) > 0) == with_depth &&
             coverage.IsFree(x, y, options.min_point_distance) &&
             (!with_depth || (support.IsSupported(x, y) && !support.IsBesideNearer(x, y)));
    };
    return SelectPoints(squared_gradient, count, is_usable, selection);
  };
  Candidate candidate;
  const std::vector<Eigen::Vector2i> measured = select(room, /*with_depth=*/true);
  const std::vector<double> sharing = NumSharingDepth(measured, frame.depth_correlation_px);
  for (size_t i = 0; i < measured.size(); ++i) {
    if (MakeCandidate(*window, options.candidates, newest, measured[i], &candidate)) {
      candidate.w_sigma *= std::sqrt(sharing[i]);
      candidate.depth_sharing = sharing[i];
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
