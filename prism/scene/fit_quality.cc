// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/scene/fit_quality.h"

namespace prism {

bool FitLimits::AreMetBy(const FitQuality& quality) const {
  return quality.rms <= max_rms && quality.outlier_fraction <= max_outlier_fraction &&
         quality.visible_fraction >= min_visible_fraction && quality.log_gain <= max_log_gain &&
         quality.depth_agreement >= min_depth_agreement && quality.misfit_area <= max_misfit_area;
}

bool FitLimits::IsValid(std::string* error) const {
  const auto is_fraction = [](double x) { return x >= 0 && x <= 1; };
  if (max_rms > 0 && is_fraction(max_outlier_fraction) && is_fraction(min_visible_fraction) &&
      is_fraction(max_misfit_area) && max_log_gain > 0 && is_fraction(min_depth_agreement)) {
    return true;
  }
  *error = "limits of a fit must be positive and fractions in [0, 1]";
  return false;
}

bool FitOptions::IsValid(std::string* error) const {
  return start.IsValid(error) && match.IsValid(error) && good.IsValid(error) &&
         held.IsValid(error) && recovered.IsValid(error);
}

}  // namespace prism
