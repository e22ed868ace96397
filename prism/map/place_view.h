// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/points/selection.h"
#include "prism/scene/frame.h"
#include "prism/scene/place.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

// What is kept of a frame: its image, features, and points whose inverse depths are known (those of
// the window, or MeasuredPoints). `keyframe_id` is for the caller.
Place MakePlace(const PlenopticProjection& camera,
                int keyframe_id,
                const LightFieldFrame& frame,
                const std::vector<ReferencePoint>& points);

// At most `count` points of a frame with the depths that it measures itself.
std::vector<ReferencePoint> MeasuredPoints(const PlenopticProjection& camera,
                                           const LightFieldFrame& frame,
                                           int count,
                                           const PointSelectionOptions& options);

// 1/m; 0: there are none.
double MedianInverseDepth(const std::vector<ReferencePoint>& points);

// A place ready for alignment: frames to it, and it to frames.
struct PlaceView {
  ImagePyramid image;
  TrackingReference reference;
};
PlaceView MakePlaceView(const PlenopticCamera& camera, const Place& place);

}  // namespace prism
