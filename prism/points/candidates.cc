// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/candidates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prism/factors/depth_offset_term.h"

namespace prism {
namespace {

// Keeps the elements for which `keep` is true, in their order.
template <typename T, typename Keep>
void RetainIf(std::vector<T>* elements, const Keep& keep) {
  elements->erase(
      std::remove_if(
          elements->begin(), elements->end(), [&](T& element) { return !keep(element); }),
      elements->end());
}

// False when the candidate has failed too often.
bool UpdateCandidate(const CandidateOptions& options,
                     const PlenopticProjection& camera,
                     const FramePair& pair,
                     const ImageViewF& image,
                     Candidate* candidate) {
  const double sigma = std::sqrt(candidate->rho_variance);
  const double rho_min = std::max(candidate->rho - options.search_sigmas * sigma, 0.0);
  const double rho_max = std::min(candidate->rho + options.search_sigmas * sigma, options.max_rho);
  if (!(rho_max > rho_min)) return false;
  const EpipolarSearchResult match =
      SearchEpipolarLine(camera, candidate->patch, pair, image, rho_min, rho_max, options.search);
  switch (match.status) {
    case EpipolarSearchStatus::kOutside:
    case EpipolarSearchStatus::kTooShort:
      return true;  // says nothing about the candidate
    case EpipolarSearchStatus::kAmbiguous:
    case EpipolarSearchStatus::kBadMatch:
      return ++candidate->failures < options.max_failures;
    case EpipolarSearchStatus::kFound:
      break;
  }
  const double difference = match.rho - candidate->rho;
  const double variance_sum = match.rho_variance + candidate->rho_variance;
  if (difference * difference >
      options.consistency_sigmas * options.consistency_sigmas * variance_sum) {
    return ++candidate->failures < options.max_failures;
  }
  // Product of the two Gaussians.
  const double gain = candidate->rho_variance / variance_sum;
  candidate->rho += gain * difference;
  candidate->rho_variance *= 1 - gain;
  candidate->failures = 0;
  ++candidate->matches;
  return true;
}

}  // namespace

bool CandidateOptions::IsValid(std::string* error) const {
  if (!search.IsValid(error)) return false;
  if (max_per_keyframe >= 0 && search_sigmas > 0 && max_rho > 0 && consistency_sigmas > 0 &&
      max_failures >= 1 && min_matches >= 0 && max_relative_sigma > 0) {
    return true;
  }
  *error = "candidates need positive limits";
  return false;
}

bool MakeCandidate(const Window& window,
                   const CandidateOptions& options,
                   const Keyframe& host,
                   const Eigen::Vector2i& px,
                   Candidate* candidate) {
  const LightFieldFrame& frame = *host.frame;
  if (!MakePatch(frame.image[0], px.cast<double>(), &candidate->patch)) return false;
  candidate->w_measured = frame.inverse_virtual_depth(px.x(), px.y());
  candidate->w_sigma = frame.sigma(px.x(), px.y());
  candidate->depth_sharing = 1;
  if (candidate->w_sigma > 0) {
    const double w = candidate->w_measured - DepthOffset(host);
    candidate->rho = std::max(InverseDepth(window.camera, w), 1e-3);
    candidate->rho_variance =
        InverseDepthVariance(window.camera, w, candidate->w_sigma * candidate->w_sigma);
  } else {
    candidate->rho = 0.5 * options.max_rho;
    const double sigma = 0.5 * options.max_rho / options.search_sigmas;
    candidate->rho_variance = sigma * sigma;
  }
  return true;
}

void UpdateCandidates(const CandidateOptions& options,
                      const ImageViewF& image,
                      const FrameState& state,
                      Window* window) {
  for (const auto& host : window->keyframes) {
    const FramePair pair = MakeFramePair(window->noise, host->state, state);
    RetainIf(&host->candidates, [&](Candidate& candidate) {
      return UpdateCandidate(options, window->camera, pair, image, &candidate);
    });
  }
}

bool ActivateCandidate(size_t host_index,
                       const Candidate& candidate,
                       DepthRefiner* refiner,
                       Window* window) {
  auto point = std::make_unique<Point>();
  point->id = window->next_point_id++;
  point->patch = candidate.patch;
  point->rho = candidate.rho;
  point->w_measured = candidate.w_measured;
  point->w_sigma = candidate.w_sigma;
  point->depth_sharing = candidate.depth_sharing;
  const DepthRefinement refined = refiner->Refine(host_index, *point);
  if (refined.factors == 0) {
    point->rho_sigma = std::sqrt(candidate.rho_variance);
  } else if (refined.success) {
    point->rho = refined.rho;
    point->rho_sigma = std::sqrt(refined.rho_variance);
  } else {
    return false;
  }
  window->keyframes[host_index]->points.push_back(std::move(point));
  return true;
}

int ActivateCandidates(const CandidateOptions& options,
                       int min_point_distance,
                       int max_points,
                       DepthRefiner* refiner,
                       CoverageMap* coverage,
                       Window* window) {
  int activated = 0;
  for (size_t i = 0; i < window->keyframes.size(); ++i) {
    Keyframe& host = *window->keyframes[i];
    const RigidMotion newest_from_host(window->newest().state.pose() * host.state.pose().Inverse());
    RetainIf(&host.candidates, [&](const Candidate& candidate) {
      const bool is_certain =
          candidate.matches >= options.min_matches &&
          std::sqrt(candidate.rho_variance) < options.max_relative_sigma * candidate.rho;
      Eigen::Vector3d x_V;
      if (!is_certain || activated >= max_points ||
          !ProjectBetweenFrames(
              window->camera, candidate.patch.px, candidate.rho, newest_from_host, &x_V) ||
          !window->newest().frame->image[0].view().Contains(x_V.x(), x_V.y(), kPatternRadius + 2) ||
          !coverage->IsFree(
              static_cast<int>(x_V.x()), static_cast<int>(x_V.y()), min_point_distance)) {
        return true;
      }
      if (!ActivateCandidate(i, candidate, refiner, window)) return false;
      coverage->Add(x_V.head<2>());
      ++activated;
      return false;
    });
  }
  return activated;
}

}  // namespace prism
