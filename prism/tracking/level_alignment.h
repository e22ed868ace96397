// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/scene/noise_model.h"
#include "prism/tracking/alignment_state.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

struct LevelAlignmentOptions {
  int max_iterations = 30;
  // Of a pixel's residual in NoiseModel::FitSigma(): where Huber's norm becomes linear (1.345 costs
  // 5 % of efficiency on Gaussian residuals), and beyond which it says nothing about the pose.
  double huber = 1.345;
  double outlier = 4.5;
  // The same of an inverse depth, in its standard deviations: beyond it the prior pulls no harder.
  double depth_huber = 2;
  // Brightness changes by no more than this on a level: else a uniform thing that hides half of the
  // view is explained by a gain of nearly 0. Larger changes are for whoever starts the alignment.
  double max_log_gain = 0.25;
  double max_offset = 25;         // 0 to 255
  bool robust = true;             // false: no Huber norm (ablation)
  bool affine_brightness = true;  // false: brightness is held (ablation)
};

// Cost over the samples of a level at one state, those of excluded points left out. Samples outside
// the image cost nothing and outliers the same wherever they are, so costs are compared per visible
// sample.
struct LevelCost {
  double energy = 0;  // sum of weighted robust squares, intensities^2
  int visible = 0;
  int inliers = 0;
  double PerSample() const { return visible > 0 ? energy / visible : INFINITY; }
};

// Aligns one level of a frame to a reference by Levenberg-Marquardt on the photometric residual
// Eq. (20), over pose, brightness and, if `free_depths`, the inverse depth of every point, which is
// known to its standard deviation: depths from single frames are uncertain by 10 % and more, and
// held fixed they turn translation into rotation (errors in variables). Depths are eliminated point
// by point (Schur complement).
class LevelAlignment {
 public:
  // What is passed must outlive it. `widening` times the outlier threshold is used. `prior`: of the
  // pose, may be null.
  LevelAlignment(const TrackingReference& reference,
                 const ImageViewF& target_image,
                 int level,
                 const NoiseModel& noise,
                 const LevelAlignmentOptions& options,
                 double widening = 1,
                 const PosePrior* prior = nullptr);

  // At the points' own depths, or at `rho` (one a point).
  LevelCost Evaluate(const AlignmentState& state) const;
  LevelCost Evaluate(const AlignmentState& state, const std::vector<double>& rho) const;

  // Returns the number of iterations. `rho`: one a point; moves only if `free_depths`.
  int Align(bool free_depths, AlignmentState* state, std::vector<double>* rho) const;

  // What a state is known by: the inverse covariance of the pose over its tangent (on the left of
  // target_from_reference), brightness and free depths eliminated.
  Matrix6d PoseInformation(const AlignmentState& state,
                           const std::vector<double>& rho,
                           bool free_depths) const;

 private:
  using Vector8d = Eigen::Matrix<double, 8, 1>;
  using Matrix8d = Eigen::Matrix<double, 8, 8>;
  struct NormalEquations;

  // `equations` may be null; those of the points only if `free_depths`.
  LevelCost Evaluate(const AlignmentState& state,
                     const std::vector<double>& rho,
                     bool free_depths,
                     NormalEquations* equations) const;
  // Subtracts what the points whose depth is known to some extent know of the state (Schur
  // complement); returns 1 / ((1 + lambda) H) of each, 0 of the others.
  std::vector<double> EliminateDepths(const NormalEquations& equations,
                                      double lambda,
                                      Matrix8d* S,
                                      Vector8d* g) const;
  bool Solve(const NormalEquations& equations,
             double lambda,
             bool free_depths,
             Vector8d* state_step,
             std::vector<double>* rho_step) const;

  const TrackingReference& reference_;
  const TrackingReference::Level& level_;
  const PlenopticProjection& camera_;
  const ImageViewF image_;
  const LevelAlignmentOptions& options_;
  const PosePrior* prior_;
  const double sigma_;              // intensities
  const double huber_threshold_;    // intensities
  const double outlier_threshold_;  // intensities
  // Of each point, filled up to a batch: its depth as it is known, and sigma_ over the standard
  // deviation of that; 0: known exactly, or excluded.
  std::vector<double> known_rho_;
  std::vector<double> prior_root_;
};

}  // namespace prism
