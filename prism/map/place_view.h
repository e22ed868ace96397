// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/scene/frame.h"
#include "prism/scene/place.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

// What is kept of a frame: its image, features, and points whose inverse depths are known (those of
// the window, AddMeasuredPoints). `keyframe_id` is for the caller.
Place MakePlace(const PlenopticProjection& camera,
                int keyframe_id,
                const LightFieldFrame& frame,
                const std::vector<ReferencePoint>& points);

// A place ready for alignment: frames to it, and it to frames.
struct PlaceView {
  ImagePyramid image;
  TrackingReference reference;
};
PlaceView MakePlaceView(const PlenopticCamera& camera, const Place& place);

}  // namespace prism
