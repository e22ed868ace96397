// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// The last steps of DepthEstimator. It estimates 1/v at nodes, every fourth pixel in x and in y:
// neighbours nearer than that look at almost the same raw pixels. Two estimates agree within twice
// the sum of their standard deviations. Deterministic, independent of threads.

inline constexpr int kNodeSpacing = 4;  // px
// The pixel of a node, and the nodes along `size` pixels.
inline int NodePixel(int node) { return kNodeSpacing * node + kNodeSpacing / 2; }
inline int NodesAlong(int size) { return (size - NodePixel(0) - 1) / kNodeSpacing + 1; }

// 1/v of every node, 0 = no estimate, its standard deviation, how far from the node's pixel the
// texture lies that it was measured on, and how far from that place it is spread, focused px. An
// estimate is that of the place of its texture: beside the contour of a near thing it is the
// contour's.
struct DepthNodes {
  ImageF depth, sigma, shift_x, shift_y, reach;

  // No estimates, for focused images of this size.
  DepthNodes(int image_width, int image_height);

  int width() const { return depth.width(); }
  int height() const { return depth.height(); }
};

// The mean of a node and those around it that agree, weighted by information and nearness; its
// sigma is the mean of theirs, as if their errors were the same, and it stays in its place. Nothing
// where no other agrees or a third contradict. `fused` has the size of `nodes`.
void FuseNeighbours(const DepthNodes& nodes, DepthNodes* fused);

// Pixels around the places of nodes: the mean of the nodes that reach them in x and in y and agree
// with the most certain of these, with weights that fall linearly to 0 at the reach in x and in y,
// if they have weight enough: alone a node is known at up to 3/4 of its reach along an axis, half
// of it along the diagonal.
void SpreadNodes(const DepthNodes& nodes, ImageF* depth, ImageF* sigmas);

}  // namespace prism
