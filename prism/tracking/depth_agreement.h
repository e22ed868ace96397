// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "prism/scene/frame.h"
#include "prism/scene/noise_model.h"
#include "prism/tracking/tracker.h"

namespace prism {

// Of the points of a reference that a frame aligned to it shows (PointFit::kFits), the fraction
// that the frame measures where they are predicted to be: measured 1/v within three standard
// deviations (0.004 at the least) of the predicted one. Nothing if fewer than 100 points meet a
// measurement. `depth_offset` is what the frame's 1/v are off by. A wrong pose that happens to look
// right fails this.
std::optional<double> DepthAgreement(const TrackingReference& reference,
                                     const FrameAlignmentResult& alignment,
                                     const LightFieldFrame& frame,
                                     double depth_offset);

// The same over what is usual (NoiseModel::UsualDepthAgreement), `unknown` where it says nothing.
// What is passed must outlive it.
Tracker::DepthCheck MakeDepthCheck(const NoiseModel& noise,
                                   const LightFieldFrame& frame,
                                   double depth_offset,
                                   double unknown);

}  // namespace prism
