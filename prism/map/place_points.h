// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Points whose depths are known, of places and of frames that see the same scene. `depth_offset`
// below is what the 1/v that a frame measures are known to be too large by.
#pragma once

#include <vector>

#include "prism/points/selection.h"
#include "prism/scene/frame.h"
#include "prism/scene/place.h"
#include "prism/tracking/tracking_reference.h"

namespace prism {

// The points of a place, for alignment.
std::vector<ReferencePoint> PointsOf(const Place& place);

// The same as a frame sees them, hidden ones too.
std::vector<ReferencePoint> PointsSeenFrom(const PlenopticProjection& camera,
                                           const Place& place,
                                           const SE3& frame_from_place);

// 1/m; 0: there are none.
double MedianInverseDepth(const std::vector<ReferencePoint>& points);

// Adds those of `seen`, points as a frame sees them, that are away from the points that are there,
// and where the frame does not measure another depth (by more than three sigmas: they are hidden).
void AddSeenPoints(const PlenopticProjection& camera,
                   const LightFieldFrame& frame,
                   double depth_offset,
                   const std::vector<ReferencePoint>& seen,
                   std::vector<ReferencePoint>* points);

// Adds points with the depths that a frame measures itself, away from those that are there, until
// there are `count` or no more.
void AddMeasuredPoints(const PlenopticProjection& camera,
                       const LightFieldFrame& frame,
                       double depth_offset,
                       int count,
                       const PointSelectionOptions& options,
                       std::vector<ReferencePoint>* points);

// A frame whose 1/v at the pixels of `seen`, points as it sees them, and next to them are what they
// say, with their sigma: where it measures nothing, or the same (within three sigmas) less
// certainly. `depth_offset` is added, as what uses the frame takes it off again.
LightFieldFrame WithKnownDepths(const PlenopticProjection& camera,
                                LightFieldFrame frame,
                                double depth_offset,
                                const std::vector<ReferencePoint>& seen);

}  // namespace prism
