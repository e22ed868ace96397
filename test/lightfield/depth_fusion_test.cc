// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_fusion.h"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

namespace prism {
namespace {

constexpr int kSize = 20;  // px

// Nodes of a field over the focused px, all with a sigma of 0.004.
template <typename Field>
DepthNodes NodesOf(const Field& field) {
  DepthNodes nodes(kSize, kSize);
  for (int j = 0; j < nodes.height(); ++j) {
    for (int i = 0; i < nodes.width(); ++i) {
      nodes.depth(i, j) = field(NodePixel(i), NodePixel(j));
      nodes.sigma(i, j) = 0.004f;
      nodes.reach(i, j) = 6;
    }
  }
  return nodes;
}

// The only node.
DepthNodes LoneNode(int i, int j) {
  DepthNodes nodes(kSize, kSize);
  nodes.depth(i, j) = 0.3f;
  nodes.sigma(i, j) = 0.004f;
  nodes.reach(i, j) = 6;
  return nodes;
}

TEST(DepthFusion, NodesCoverTheImage) {
  for (int size = 3; size < 14; ++size) {
    EXPECT_LT(NodePixel(NodesAlong(size) - 1), size);
    EXPECT_GE(NodePixel(NodesAlong(size)), size);
  }
}

TEST(DepthFusion, SpreadNodesInterpolateAPlane) {
  const auto plane = [](int x, int y) {
    return 0.3f + 1e-4f * static_cast<float>(x) - 2e-4f * static_cast<float>(y);
  };
  const DepthNodes nodes = NodesOf(plane);
  ImageF depth(kSize, kSize), sigmas(kSize, kSize);
  SpreadNodes(nodes, &depth, &sigmas);
  const int first = NodePixel(1);
  const int last = NodePixel(nodes.width() - 2);
  for (int y = first; y <= last; ++y) {
    for (int x = first; x <= last; ++x) {
      EXPECT_NEAR(depth(x, y), plane(x, y), 1e-4) << x << " " << y;  // half a pixel of its slope
      EXPECT_NEAR(sigmas(x, y), 0.004, 1e-6);
    }
  }
}

TEST(DepthFusion, NothingIsInterpolatedAcrossAnEdge) {
  const DepthNodes nodes = NodesOf([](int x, int) { return x < 10 ? 0.2f : 0.4f; });
  ImageF depth(kSize, kSize), sigmas(kSize, kSize);
  SpreadNodes(nodes, &depth, &sigmas);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      if (depth(x, y) == 0) continue;
      EXPECT_TRUE(std::abs(depth(x, y) - 0.2f) < 1e-6f || std::abs(depth(x, y) - 0.4f) < 1e-6f);
    }
    EXPECT_GT(depth(6, y), 0);
    EXPECT_GT(depth(12, y), 0);
  }
}

TEST(DepthFusion, ALoneNodeIsKnownAroundItsPlace) {
  ImageF depth(kSize, kSize), sigmas(kSize, kSize);
  SpreadNodes(LoneNode(2, 2), &depth, &sigmas);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const int u = std::abs(x - NodePixel(2));
      const int v = std::abs(y - NodePixel(2));
      if (u + v <= 4) {
        EXPECT_FLOAT_EQ(depth(x, y), 0.3f) << x << " " << y;
      } else if (std::max(u, v) > 4) {
        EXPECT_EQ(depth(x, y), 0) << x << " " << y;
      }
      EXPECT_EQ(sigmas(x, y) > 0, depth(x, y) > 0);
    }
  }
}

TEST(DepthFusion, ANodeIsKnownAroundThePlaceItWasMovedTo) {
  DepthNodes nodes = LoneNode(2, 2);
  nodes.shift_x(2, 2) = 3;
  nodes.shift_y(2, 2) = -2;
  ImageF depth(kSize, kSize), sigmas(kSize, kSize), unmoved(kSize, kSize);
  SpreadNodes(LoneNode(2, 2), &unmoved, &sigmas);
  SpreadNodes(nodes, &depth, &sigmas);
  for (int y = 2; y < kSize; ++y) {
    for (int x = 0; x < kSize - 3; ++x) {
      EXPECT_FLOAT_EQ(depth(x + 3, y - 2), unmoved(x, y)) << x << " " << y;
    }
  }
}

TEST(DepthFusion, NodesAreAveragedAndThoseThatAreAloneOrContradictedDropped) {
  DepthNodes nodes = NodesOf([](int, int) { return 0.3f; });
  nodes.depth(2, 2) = 0.31f;  // agrees
  nodes.depth(4, 4) = 0.4f;   // does not
  nodes.shift_x(2, 2) = 1.5f;
  DepthNodes fused(kSize, kSize);
  FuseNeighbours(nodes, &fused);
  EXPECT_EQ(fused.depth(4, 4), 0);
  EXPECT_EQ(fused.sigma(4, 4), 0);
  EXPECT_GT(fused.depth(2, 2), 0.3f);
  EXPECT_LT(fused.depth(2, 2), 0.305f);
  EXPECT_NEAR(fused.sigma(2, 2), 0.004, 1e-6);
  EXPECT_EQ(fused.shift_x(2, 2), 1.5f);
  EXPECT_FLOAT_EQ(fused.depth(0, 0), 0.3f);

  FuseNeighbours(LoneNode(3, 3), &fused);
  EXPECT_EQ(fused.depth(3, 3), 0);
}

}  // namespace
}  // namespace prism
