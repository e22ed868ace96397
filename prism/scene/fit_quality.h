// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>

namespace prism {

// How well a frame fits what is known of the scene, by whoever has aligned or optimised it.
struct FitQuality {
  double rms = INFINITY;        // of residuals that are no outliers, in NoiseModel::FitSigma()
  double outlier_fraction = 1;  // of the residuals, or of the points they belong to
  double visible_fraction = 0;  // of what was looked for
  double log_gain = 0;          // change of brightness, |a|, against what was expected
  // DepthAgreement over what is usual; 1 where it is not asked for or says nothing.
  double depth_agreement = 1;
  // Of the areas of the image that show enough points, those in which most do not fit: hidden, or
  // of another place that looks alike. 0 where points have no area.
  double misfit_area = 0;
};

// "Is this fit good?", in one set of limits for each use.
struct FitLimits {
  double max_rms = 4;  // NoiseModel::FitSigma()
  double max_outlier_fraction = 0.5;
  double min_visible_fraction = 0.3;
  double max_log_gain = 0.7;
  double min_depth_agreement = 0;
  double max_misfit_area = 1;

  bool AreMetBy(const FitQuality& quality) const;
  bool IsValid(std::string* error) const;
};

struct FitOptions {
  // Of a frame while few frames tell what fits: a third of outliers is still a match.
  FitLimits start = {4, 0.35, 0.3, 0.7, 0.4};
  // Of a frame once that is known.
  FitLimits match = {2.5, 0.75, 0.3, 0.7, 0.8};  // half the view may be hidden
  // A fit that leaves nothing to ask for: beyond it, other starts are tried.
  FitLimits good = {1.5, 0.15, 0.3, 0.7, 0};
  // Of a frame that shows little and is held by motion: most may be hidden.
  FitLimits held = {2, 0.97, 0, 0.7, 0.8};
  // After a loss: nothing but the images speaks for a match, and a wrong pose spoils the map.
  FitLimits recovered = {1.5, 0.2, 0.5, 0.3, 0.8, 0.08};

  bool IsValid(std::string* error) const;
};

}  // namespace prism
