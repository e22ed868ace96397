// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/photometric_term.h"

#include <cmath>

#include <glog/logging.h>

#include "prism/factors/photometric.h"
#include "prism/factors/visibility.h"

namespace prism {

bool PhotometricTermOptions::IsValid(std::string* error) const {
  if (cauchy >= 0 && outliers.max_rms > 0 && outliers.quantile_factor >= 0 &&
      outliers.quantile > 0 && outliers.quantile <= 1) {
    return true;
  }
  *error =
      "the photometric term needs a Cauchy scale of 0 or more, a positive outlier threshold and "
      "a quantile in (0, 1]";
  return false;
}

PhotometricTerm::PhotometricTerm(const PhotometricTermOptions& options) : options_(options) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  if (options.cauchy > 0) {
    loss_ = std::make_unique<ceres::CauchyLoss>(options.cauchy * std::sqrt(double{kPatternSize}));
  }
}

void PhotometricTerm::AddPointFactors(const Window& window,
                                      size_t host_index,
                                      const Point& point,
                                      int rho_block,
                                      WindowGraph* graph) const {
  for (size_t j = 0; j < window.keyframes.size(); ++j) {
    if (j == host_index) continue;
    const Keyframe& target = *window.keyframes[j];
    const FramePair& pair = graph->pair(host_index, j);
    if (!IsObserved(window.camera, pair.current.target_from_host, point, target)) continue;
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<PhotometricCost>(
        &point.patch, &pair, target.frame->image[0], &window.camera);
    factor.loss = loss_.get();
    factor.group = target.id;
    factor.keeps_first_estimates = true;
    graph->AddFactor(std::move(factor),
                     {graph->FrameBlock(host_index), graph->FrameBlock(j), rho_block});
  }
}

void PhotometricTerm::Reject(const FactorGraph::Factor& factor,
                             Point* point,
                             Window* /*window*/) const {
  point->outlier_targets.push_back(factor.group);
}

}  // namespace prism
