// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/epipolar_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "prism/residual/photometric.h"

namespace prism {
namespace {

using Vector8d = Eigen::Matrix<double, kPatternSize, 1>;

// Image of the patch centre at an inverse depth; false if it is behind the focal length.
bool ProjectCenter(const PlenopticProjection& camera,
                   const PhotometricPatch& patch,
                   const FramePair& pair,
                   double rho,
                   Eigen::Vector2d* px) {
  const SE3 target_from_host(Eigen::Quaterniond(pair.current.R), pair.current.t);
  Eigen::Vector3d x_V;
  if (!ProjectBetweenFrames(camera, patch.px, rho, target_from_host, &x_V)) return false;
  *px = x_V.head<2>();
  return true;
}

// Squared error of the patch at an inverse depth, mean over the pattern, in variances; infinite
// where the pattern leaves the image. Optionally the normal equation of rho.
double SquaredError(const PhotometricCost& cost,
                    double rho,
                    double* H = nullptr,
                    double* g = nullptr) {
  const double* parameters[] = {nullptr, nullptr, &rho};
  Vector8d r, J;
  double* jacobians[] = {nullptr, nullptr, J.data()};
  cost.Evaluate(parameters, r.data(), jacobians);
  if (J.squaredNorm() == 0) return INFINITY;
  if (H != nullptr) {
    *H = J.squaredNorm();
    *g = J.dot(r);
  }
  return r.squaredNorm() / kPatternSize;
}

}  // namespace

bool EpipolarSearchOptions::IsValid(std::string* error) const {
  if (step > 0 && max_length > min_length && min_length > 0 && max_rms > 0 && min_uniqueness >= 1) {
    return true;
  }
  *error =
      "the epipolar search needs a positive step and RMS, a longest length above the shortest "
      "and a uniqueness of 1 or more";
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
  Eigen::Vector2d near_px, far_px;
  if (!ProjectCenter(camera, patch, pair, rho_min, &far_px) ||
      !ProjectCenter(camera, patch, pair, rho_max, &near_px)) {
    return result;
  }
  const double length = (near_px - far_px).norm();
  if (length < options.min_length) {
    result.status = EpipolarSearchStatus::kTooShort;
    return result;
  }
  if (length > options.max_length) {
    result.status = EpipolarSearchStatus::kTooLong;
    return result;
  }

  // Along the line the pixel is (p0 + rho p1) / (d0 + rho d1), so equal steps in pixels are
  // fractions s with rho = rho_min + (rho_max - rho_min) s / (k + s (1 - k)), k = D(rho_max) /
  // D(rho_min).
  const Eigen::Vector2d m = (patch.px - camera.c) * (camera.s / camera.f);
  const auto denominator = [&](double rho) {
    const Eigen::Vector3d ray(m.x() * (1 - rho * camera.f), m.y() * (1 - rho * camera.f), 1);
    return (pair.current.R * ray + rho * pair.current.t).z() - rho * camera.f;
  };
  const double k = denominator(rho_max) / denominator(rho_min);
  const int steps = std::max(2, static_cast<int>(std::ceil(length / options.step)));
  const auto rho_at = [&](double s) {
    return rho_min + (rho_max - rho_min) * s / (k + s * (1 - k));
  };
  const PhotometricCost cost(&patch, &pair, target_image, &camera);
  std::vector<double> errors(steps + 1);
  int best = 0;
  for (int i = 0; i <= steps; ++i) {
    errors[i] = SquaredError(cost, rho_at(static_cast<double>(i) / steps));
    if (errors[i] < errors[best]) best = i;
  }
  if (!std::isfinite(errors[best])) return result;

  // Gauss-Newton inside the two steps around the best.
  const double low = rho_at(std::max(best - 1, 0) / static_cast<double>(steps));
  const double high = rho_at(std::min(best + 1, steps) / static_cast<double>(steps));
  double rho = rho_at(static_cast<double>(best) / steps);
  double H, g;
  double error = SquaredError(cost, rho, &H, &g);
  for (int iteration = 0; iteration < options.refinement_iterations; ++iteration) {
    const double candidate = std::clamp(rho - g / H, std::min(low, high), std::max(low, high));
    double candidate_H, candidate_g;
    const double candidate_error = SquaredError(cost, candidate, &candidate_H, &candidate_g);
    if (!(candidate_error < error)) break;
    rho = candidate;
    error = candidate_error;
    H = candidate_H;
    g = candidate_g;
  }
  result.rho = rho;
  result.rho_variance = std::max(error, 1.0) / H;
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
