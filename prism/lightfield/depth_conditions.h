// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "prism/image/image.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/scene/frame.h"

namespace prism {

// What the error of a measured 1/v may depend on, at one pixel of the focused grid. "Views" are
// those that are compared at the true 1/v: of the lens types DefocusMatch uses, at most as many as
// DepthEstimator takes.
struct DepthConditions {
  double true_inverse_virtual_depth = 0;
  double distance_m = 0;  // z at that depth; infinite at or beyond infinity
  double contrast = 0;    // |gradient| of the focused image, a px, over the noise of the raw image

  // Of texture that repeats itself along a baseline, raw px: the smallest lag, along the directions
  // to the nearest lenses, at which the micro image beside the chief ray correlates with itself by
  // more than 0.5 again, after it did so by at least 0.2 less. NaN: it does not within half a
  // pitch.
  double texture_period_px = NAN;

  // Between gradient and the nearest of these directions, 0 to 30 degrees (NaN: no gradient).
  double lens_axis_angle_deg = NAN;

  // Distance to the nearest depth edge, where the true 1/v of neighbours differs by more than 0.01,
  // focused px. Positive on the near side, negative on the far side; NaN: none within 30 px.
  double depth_edge_distance_px = NAN;

  double image_radius_px = 0;  // distance from the image centre, focused px
  int sharpest_type = 0;       // the lens type whose focus is nearest
  int types_used = 0;          // bit k: type k is compared

  // Distance from the centre of the micro image, raw px: mean of the views, and of the one nearest
  // to the chief ray (NaN without views).
  double view_radius_px = NAN;
  double chief_view_radius_px = NAN;

  double slant = NAN;  // |gradient of true 1/v|, a focused px; NaN within 3.5 px of a depth edge
};

// Conditions at pixels of `frame`, the last one `processor` has processed; `truth` is its true 1/v
// on the focused grid (0: none). Precondition: each pixel has truth and lies within the image by a
// pixel or more.
std::vector<DepthConditions> MeasureDepthConditions(const LightFieldProcessor& processor,
                                                    const LightFieldFrame& frame,
                                                    const ImageF& truth,
                                                    const std::vector<Eigen::Vector2i>& pixels);

}  // namespace prism
