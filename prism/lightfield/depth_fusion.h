// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// The last steps of DepthEstimator. It estimates 1/v at nodes, every fourth pixel in x and in y:
// neighbours nearer than that look at almost the same raw pixels. Images of 1/v and of its standard
// deviation, 0 = no estimate. Two estimates agree within twice the sum of their standard
// deviations. Deterministic, independent of threads.

inline constexpr int kNodeSpacing = 4;  // px
// The pixel of a node, and the nodes along `size` pixels.
inline int NodePixel(int node) { return kNodeSpacing * node + kNodeSpacing / 2; }
inline int NodesAlong(int size) { return (size - NodePixel(0) - 1) / kNodeSpacing + 1; }

// The mean of a node and those around it that agree, weighted by information and nearness; its
// sigma is the mean of theirs, as if their errors were the same. Nothing where no other agrees or a
// third contradict. `fused` and `fused_sigmas` have the size of the others.
void FuseNeighbours(const ImageF& nodes,
                    const ImageF& node_sigmas,
                    ImageF* fused,
                    ImageF* fused_sigmas);

// Pixels between nodes: interpolated between those that agree with the most certain one of the four
// around, if they have most of the weight.
void SpreadNodes(const ImageF& nodes, const ImageF& node_sigmas, ImageF* depth, ImageF* sigmas);

}  // namespace prism
