// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "prism/scene/noise_model.h"
#include "prism/tracking/alignment_state.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

enum class PointFit : char { kUnseen, kFits, kOutlier };

struct PointFits {
  std::vector<PointFit> fits;  // one a point of the reference, excluded ones too
  // Of points that are not excluded:
  int seen = 0;
  int outliers = 0;
  double misfit_area = 0;  // FitQuality::misfit_area
  double rms = INFINITY;   // of the samples of points that fit, intensities

  double OutlierFraction() const { return seen > 0 ? static_cast<double>(outliers) / seen : 1; }
  // So many do not fit that something is before them.
  bool AreManyHidden() const { return OutlierFraction() >= 0.15; }
};

// How the points of a reference fit the finest level of a frame aligned to it;
// `rho`: their inverse depths, 1/m. A point is an outlier if the RMS of its pattern is large, or if
// its texture is not there (the residuals' deviation from their mean is not much smaller than the
// pattern's own: something uniform is before it). What hides or moves covers an area: where most
// points of a cell of the image are outliers, all of them are.
PointFits JudgePoints(const TrackingReference& reference,
                      const ImageViewF& target_image,
                      const AlignmentState& state,
                      const std::vector<double>& rho,
                      const NoiseModel& noise);

}  // namespace prism
