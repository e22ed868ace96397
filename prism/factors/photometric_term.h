// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "prism/factors/term.h"

namespace prism {

struct PhotometricTermOptions {
  // Scale of Cauchy's loss in standard deviations, over the norm of a pattern's 8 residuals /
  // sqrt(8). 0: squares (ablation). With Huber's, what hides a part of the view drags the
  // brightness of a frame along.
  double cauchy = 1.5;
  // DSO's frame energy threshold on a pattern's RMS; groups are target frames.
  OutlierRule outliers = {3, 2, 0.7};

  bool IsValid(std::string* error) const;
};

// A PhotometricCost for every point in every keyframe that observes it (Eqs. (20), (21)).
// Group of a factor: id of the target keyframe.
class PhotometricTerm : public Term {
 public:
  explicit PhotometricTerm(const PhotometricTermOptions& options);

  static constexpr char kName[] = "photometric";
  std::string name() const override { return kName; }
  void AddPointFactors(const Window& window,
                       size_t host_index,
                       const Point& point,
                       int rho_block,
                       WindowGraph* graph) const override;
  OutlierRule outlier_rule() const override { return options_.outliers; }
  // The point is not looked for in that keyframe again.
  void Reject(const FactorGraph::Factor& factor, Point* point, Window* window) const override;

 private:
  PhotometricTermOptions options_;
  std::unique_ptr<const ceres::LossFunction> loss_;
};

}  // namespace prism
