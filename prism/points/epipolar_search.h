// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/camera/projection.h"
#include "prism/factors/frame_pair.h"
#include "prism/image/image.h"
#include "prism/image/patch.h"

namespace prism {

struct EpipolarSearchOptions {
  double step = 1;               // px along the epipolar line
  double max_length = 60;        // px: of a longer line the far end alone is searched
  double min_length = 1.5;       // px: on a shorter one a match would not tell the depth
  double max_rms = 3;            // standard deviations of a residual
  double min_uniqueness = 1.5;   // squared error of the second best match over that of the best
  double uniqueness_radius = 3;  // px around the best match that do not count as second best
  int refinement_iterations = 3;

  bool IsValid(std::string* error) const;
};

enum class EpipolarSearchStatus {
  kFound,
  kOutside,   // the line does not pass through the image
  kTooShort,  // the parallax is too small to tell the depth
  kAmbiguous,
  kBadMatch,
};

struct EpipolarSearchResult {
  EpipolarSearchStatus status = EpipolarSearchStatus::kOutside;
  double rho = 0;           // 1/m, in the host frame
  double rho_variance = 0;  // 1/m^2, from the residuals' derivative at the match
  double rms = 0;           // standard deviations
};

// Finds the inverse depth in [rho_min, rho_max] at which a host patch matches a target image best:
// a scan along the epipolar curve of the plenoptic projection, then Gauss-Newton on the photometric
// residual Eq. (20). As the focused image is a pinhole image (PlenopticProjection), the
// curve is a straight line, walked by equal steps in pixels.
EpipolarSearchResult SearchEpipolarLine(const PlenopticProjection& camera,
                                        const PhotometricPatch& patch,
                                        const FramePair& pair,
                                        const ImageViewF& target_image,
                                        double rho_min,
                                        double rho_max,
                                        const EpipolarSearchOptions& options);

}  // namespace prism
