// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/points/coverage.h"
#include "prism/points/epipolar_search.h"
#include "prism/points/refinement.h"
#include "prism/scene/window.h"

namespace prism {

struct CandidateOptions {
  EpipolarSearchOptions search;
  int max_per_keyframe = 300;
  double search_sigmas = 2.5;       // half width of the search in standard deviations
  double max_rho = 10;              // 1/m, nearest depth a candidate without measurement may have
  double consistency_sigmas = 3;    // a match farther from the estimate is a failure
  int max_failures = 3;             // in a row, then the candidate is dropped
  int min_matches = 2;              // to be activated
  double max_relative_sigma = 0.1;  // of rho, to be activated

  bool IsValid(std::string* error) const;
};

// A candidate at a pixel of the host: its depth measured there with its variance, or, where nothing
// is measured, anything between infinity and `max_rho`. False if the patch does not fit.
bool MakeCandidate(const Window& window,
                   const CandidateOptions& options,
                   const Keyframe& host,
                   const Eigen::Vector2i& px,
                   Candidate* candidate);

// Looks for every candidate of the window in a new frame at a known state and narrows its depth
// down. Candidates that fail too often in a row are dropped.
void UpdateCandidates(const CandidateOptions& options,
                      const ImageViewF& image,
                      const FrameState& state,
                      Window* window);

// Turns a candidate of `window->keyframes[host_index]` into a point of it, with the depth that
// `refiner` (of this window) finds; false if that fails. Where no term speaks of it (without depth
// residuals, in the first keyframe) it keeps the candidate's depth.
bool ActivateCandidate(size_t host_index,
                       const Candidate& candidate,
                       DepthRefiner* refiner,
                       Window* window);

// Certain candidates that fill a gap in `coverage` become points of their keyframes, at most
// `max_points` of them. Returns their number. Candidates that ActivateCandidate refuses are
// dropped.
int ActivateCandidates(const CandidateOptions& options,
                       int min_point_distance,
                       int max_points,
                       DepthRefiner* refiner,
                       CoverageMap* coverage,
                       Window* window);

}  // namespace prism
