// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/epipolar_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "prism/factors/photometric.h"

namespace prism {
namespace {

// A patch against a target image at one depth after the other.
class PatchMatcher {
 public:
  PatchMatcher(const PlenopticProjection& camera,
               const PhotometricPatch& patch,
               const FramePair& pair,
               const ImageViewF& target_image)
      : camera_(camera), patch_(patch), pair_(pair), target_image_(target_image) {}

  struct Match {
    double squared_error = INFINITY;  // mean over the pattern, in variances
    double H = 0, g = 0;              // normal equation of rho
  };
  // Infinite error where the pattern leaves the image.
  Match At(double rho) const {
    PatternMatch match;
    if (!EvaluatePattern(patch_, pair_, target_image_, camera_, rho, &match)) return {};
    const double H = match.J_rho.squaredNorm();
    if (H == 0) return {};
    return {match.residuals.squaredNorm() / kPatternSize, H, match.J_rho.dot(match.residuals)};
  }

 private:
  const PlenopticProjection& camera_;
  const PhotometricPatch& patch_;
  const FramePair& pair_;
  const ImageViewF& target_image_;
};

}  // namespace

bool EpipolarSearchOptions::IsValid(std::string* error) const {
  if (step > 0 && max_length > min_length && min_length > 0 && max_rms > 0 && min_uniqueness >= 1 &&
      uniqueness_radius >= 0 && refinement_iterations >= 0) {
    return true;
  }
  *error =
      "the epipolar search needs a positive step and RMS, a longest length above the shortest "
      "a uniqueness of 1 or more, and a radius and iterations of 0 or more";
  return false;
}

EpipolarSearchResult SearchEpipolarLine(const PlenopticProjection& camera,
                                        const PhotometricPatch& patch,
                                        const FramePair& pair,
                                        const ImageViewF& target_image,
                                        double rho_min,
                                        double rho_max,
                                        const EpipolarSearchOptions& options) {
  EpipolarSearchResult result;
  const RigidMotion& target_from_host = pair.current.target_from_host;
  Eigen::Vector3d near_px, far_px;
  if (!ProjectBetweenFrames(camera, patch.px, rho_min, target_from_host, &far_px) ||
      !ProjectBetweenFrames(camera, patch.px, rho_max, target_from_host, &near_px)) {
    return result;
  }
  const double full_length = (near_px - far_px).head<2>().norm();
  if (full_length < options.min_length) {
    result.status = EpipolarSearchStatus::kTooShort;
    return result;
  }

  // Along the line the pixel is (p0 + rho p1) / (d0 + rho d1), so equal steps in pixels are
  // fractions s with rho = rho_min + (rho_max - rho_min) s / (k + s (1 - k)), k = D(rho_max) /
  // D(rho_min).
  const auto denominator = [&](double rho) {
    const Eigen::Vector3d ray = ScaledRay(camera, patch.px, rho);
    return (target_from_host.R * ray + rho * target_from_host.t).z() - rho * camera.center_z();
  };
  const double k = denominator(rho_max) / denominator(rho_min);
  // Most things are far: of a long line, that end (as in DSO).
  const double length = std::min(full_length, options.max_length);
  const int steps = std::max(2, static_cast<int>(std::ceil(length / options.step)));
  const auto rho_at = [&](double fraction) {
    const double s = fraction * length / full_length;
    return rho_min + (rho_max - rho_min) * s / (k + s * (1 - k));
  };
  const PatchMatcher matcher(camera, patch, pair, target_image);
  std::vector<double> errors(steps + 1);
  int best = 0;
  for (int i = 0; i <= steps; ++i) {
    errors[i] = matcher.At(rho_at(static_cast<double>(i) / steps)).squared_error;
    if (errors[i] < errors[best]) best = i;
  }
  if (!std::isfinite(errors[best])) return result;
  if (best == steps && length < full_length) {  // a better one may follow
    result.status = EpipolarSearchStatus::kAmbiguous;
    return result;
  }

  // Gauss-Newton inside the two steps around the best.
  const double low = rho_at(std::max(best - 1, 0) / static_cast<double>(steps));
  const double high = rho_at(std::min(best + 1, steps) / static_cast<double>(steps));
  double rho = rho_at(static_cast<double>(best) / steps);
  PatchMatcher::Match match = matcher.At(rho);
  for (int iteration = 0; iteration < options.refinement_iterations; ++iteration) {
    const double candidate =
        std::clamp(rho - match.g / match.H, std::min(low, high), std::max(low, high));
    const PatchMatcher::Match next = matcher.At(candidate);
    if (!(next.squared_error < match.squared_error)) break;
    rho = candidate;
    match = next;
  }
  const double error = match.squared_error;
  result.rho = rho;
  result.rho_variance = std::max(error, 1.0) / match.H;
  result.rms = std::sqrt(error);
  if (result.rms > options.max_rms) {
    result.status = EpipolarSearchStatus::kBadMatch;
    return result;
  }
  const double radius = options.uniqueness_radius * steps / length;
  for (int i = 0; i <= steps; ++i) {
    if (std::abs(i - best) > radius && errors[i] < options.min_uniqueness * std::max(error, 0.1)) {
      result.status = EpipolarSearchStatus::kAmbiguous;
      return result;
    }
  }
  result.status = EpipolarSearchStatus::kFound;
  return result;
}

}  // namespace prism
