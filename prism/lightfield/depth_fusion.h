// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// What neighbouring estimates of inverse virtual depth make of each other, the last steps of
// DepthEstimator. Images of 1/v and of its standard deviation, 0 = no estimate. Two agree within
// twice the sum of their standard deviations. Deterministic, independent of threads.

// Estimates at every second pixel, those with x + y even: the others become the mean of those of
// their four neighbours that agree with the most certain one, if there are two.
void FillBetween(ImageF* depth, ImageF* sigmas);

// The mean of the agreeing estimates within 3 px, weighted by information and nearness; its sigma
// is the mean of theirs, as if their errors were the same. Nothing where fewer than 8 agree or a
// third contradict. `fused` and `fused_sigmas` have the size of the others.
void FuseNeighbours(const ImageF& depth, const ImageF& sigmas, ImageF* fused, ImageF* fused_sigmas);

}  // namespace prism
