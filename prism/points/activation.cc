// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/activation.h"

#include <algorithm>

namespace prism {

bool ActivationOptions::IsValid(std::string* error) const {
  if (!selection.IsValid(error) || !candidates.IsValid(error) || !refinement.IsValid(error)) {
    return false;
  }
  if (max_new_points >= 1 && min_point_distance >= 1) return true;
  *error = "activation needs a point or more and a distance of 1 px or more";
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
  int room = max_points - window->NumPoints();
  if (newest_index > 0) {
    room = std::min(room, options.max_new_points);
    room -= ActivateCandidates(
        options.candidates, options.min_point_distance, room, &refiner, &coverage, window);
  }
  const ImageF squared_gradient = SquaredGradientMagnitude(frame.image[0]);
  const auto select = [&](int count, bool with_depth) {
    const auto is_usable = [&](int x, int y) {
      return (frame.sigma(x, y) > 0) == with_depth &&
             coverage.IsFree(x, y, options.min_point_distance);
    };
    return SelectPoints(squared_gradient, count, is_usable, options.selection);
  };
  Candidate candidate;
  for (const Eigen::Vector2i& px : select(room, /*with_depth=*/true)) {
    if (MakeCandidate(*window, options.candidates, newest, px, &candidate)) {
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
