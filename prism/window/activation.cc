// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/activation.h"

#include <algorithm>
#include <cmath>

#include "prism/residual/frame_pair.h"
#include "prism/residual/inverse_virtual_depth.h"
#include "prism/residual/photometric.h"

namespace prism {
namespace {

// Normal equation of the one unknown.
struct ScalarSystem {
  double H = 0;  // photometric and measurement
  double g = 0;
  double energy = 0;
  double squared_photometric = 0;
  int observations = 0;
};

}  // namespace

DepthRefinement RefineInverseDepth(const Window& window,
                                   const WindowOptions& window_options,
                                   size_t host_index,
                                   const Point& point,
                                   const RefinementOptions& options) {
  const Keyframe& host = *window.keyframes[host_index];
  Point trial = point;
  std::vector<FramePair> pairs;
  std::vector<const Keyframe*> targets;
  for (size_t j = 0; j < window.keyframes.size(); ++j) {
    if (j == host_index || !IsObserved(window, host, trial, *window.keyframes[j])) continue;
    targets.push_back(window.keyframes[j].get());
    pairs.emplace_back().Update(host.state, targets.back()->state);
  }

  const double huber = window_options.photometric_huber * std::sqrt(double{kPatternSize});
  const bool has_depth = trial.w_sigma > 0;
  const auto evaluate = [&](double rho) {
    ScalarSystem system;
    for (size_t i = 0; i < targets.size(); ++i) {
      const PhotometricCost cost(
          &trial.patch, &pairs[i], targets[i]->frame->image[0], &window.camera);
      const double* parameters[] = {host.state.data(), targets[i]->state.data(), &rho};
      Eigen::Matrix<double, kPatternSize, 1> r, J;
      double* jacobians[] = {nullptr, nullptr, J.data()};
      cost.Evaluate(parameters, r.data(), jacobians);
      const double norm = r.norm();
      if (J.squaredNorm() == 0) continue;
      const double weight = norm > huber ? huber / norm : 1;
      system.H += weight * J.squaredNorm();
      system.g += weight * J.dot(r);
      system.energy += norm > huber ? huber * (2 * norm - huber) : norm * norm;
      system.squared_photometric += weight * r.squaredNorm();
      ++system.observations;
    }
    if (has_depth) {
      double dw_drho;
      const double r =
          (InverseVirtualDepth(window.camera, rho, &dw_drho) - trial.w_measured) / trial.w_sigma;
      const double J = dw_drho / trial.w_sigma;
      system.H += J * J;
      system.g += J * r;
      system.energy += r * r;
    }
    return system;
  };

  DepthRefinement result;
  double rho = trial.rho;
  ScalarSystem system = evaluate(rho);
  double damping = 1;
  for (int iteration = 0; iteration < options.max_iterations && system.H > 0; ++iteration) {
    const double candidate = std::max(rho - damping * system.g / system.H, 1e-4);
    const ScalarSystem next = evaluate(candidate);
    if (next.energy < system.energy && next.observations >= system.observations) {
      const double gain = 1 - next.energy / system.energy;
      rho = candidate;
      system = next;
      if (gain < 1e-3) break;
    } else {
      damping *= 0.3;
    }
  }
  if (!(system.H > 0) || (system.observations == 0 && !has_depth)) return result;
  result.rho = rho;
  result.rho_variance = 1 / system.H;
  result.observations = system.observations;
  if (system.observations > 0) {
    result.rms = std::sqrt(system.squared_photometric / (kPatternSize * system.observations));
  }
  result.success = result.rms <= options.max_rms &&
                   std::sqrt(result.rho_variance) <= options.max_relative_sigma * result.rho;
  return result;
}

CoverageMap::CoverageMap(const Window& window)
    : columns_(window.camera.width / kCell + 1),
      rows_(window.camera.height / kCell + 1),
      first_(static_cast<size_t>(columns_) * rows_, -1) {
  const Keyframe& newest = window.newest();
  for (const auto& host : window.keyframes) {
    const SE3 newest_from_host = newest.state.pose() * host->state.pose().Inverse();
    for (const auto& point : host->points) {
      Eigen::Vector3d x_V;
      if (ProjectBetweenFrames(
              window.camera, point->patch.px, point->rho, newest_from_host, &x_V)) {
        Add(x_V.head<2>());
      }
    }
  }
}

void CoverageMap::Add(const Eigen::Vector2d& px) {
  const int column = static_cast<int>(std::floor(px.x() / kCell));
  const int row = static_cast<int>(std::floor(px.y() / kCell));
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  int& head = first_[static_cast<size_t>(row) * columns_ + column];
  next_.push_back(head);
  points_.push_back(px);
  head = static_cast<int>(points_.size()) - 1;
}

bool CoverageMap::IsFree(int x, int y, int radius) const {
  const int column0 = std::max((x - radius) / kCell, 0);
  const int row0 = std::max((y - radius) / kCell, 0);
  const int column1 = std::min((x + radius) / kCell, columns_ - 1);
  const int row1 = std::min((y + radius) / kCell, rows_ - 1);
  for (int row = row0; row <= row1; ++row) {
    for (int column = column0; column <= column1; ++column) {
      for (int i = first_[static_cast<size_t>(row) * columns_ + column]; i >= 0; i = next_[i]) {
        if ((points_[i] - Eigen::Vector2d(x, y)).cwiseAbs().maxCoeff() <= radius) return false;
      }
    }
  }
  return true;
}

}  // namespace prism
