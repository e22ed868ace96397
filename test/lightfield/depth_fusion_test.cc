// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_fusion.h"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

namespace prism {
namespace {

constexpr int kSize = 20;  // px

// Nodes of a field over the focused px, all with one sigma.
template <typename Field>
ImageF NodesOf(const Field& field) {
  ImageF nodes(NodesAlong(kSize), NodesAlong(kSize));
  for (int j = 0; j < nodes.height(); ++j) {
    for (int i = 0; i < nodes.width(); ++i) nodes(i, j) = field(NodePixel(i), NodePixel(j));
  }
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
  const ImageF nodes = NodesOf(plane);
  const ImageF node_sigmas(nodes.width(), nodes.height(), 0.004f);
  ImageF depth(kSize, kSize), sigmas(kSize, kSize);
  SpreadNodes(nodes, node_sigmas, &depth, &sigmas);
  const int first = NodePixel(0);
  const int last = NodePixel(nodes.width() - 1);
  for (int y = first; y <= last; ++y) {
    for (int x = first; x <= last; ++x) {
      EXPECT_NEAR(depth(x, y), plane(x, y), 1e-6) << x << " " << y;
      EXPECT_NEAR(sigmas(x, y), 0.004, 1e-6);
    }
  }
}

TEST(DepthFusion, NothingIsInterpolatedAcrossAnEdge) {
  const ImageF nodes = NodesOf([](int x, int) { return x < 10 ? 0.2f : 0.4f; });
  const ImageF node_sigmas(nodes.width(), nodes.height(), 0.004f);
  ImageF depth(kSize, kSize), sigmas(kSize, kSize);
  SpreadNodes(nodes, node_sigmas, &depth, &sigmas);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      if (depth(x, y) == 0) continue;
      EXPECT_TRUE(std::abs(depth(x, y) - 0.2f) < 1e-6f || std::abs(depth(x, y) - 0.4f) < 1e-6f);
    }
    EXPECT_GT(depth(6, y), 0);
    EXPECT_GT(depth(12, y), 0);
  }
}

TEST(DepthFusion, ALoneNodeIsKnownAsFarAsItIsTheNearest) {
  ImageF nodes(NodesAlong(kSize), NodesAlong(kSize), 0);
  ImageF node_sigmas(nodes.width(), nodes.height(), 0);
  nodes(2, 3) = 0.3f;
  node_sigmas(2, 3) = 0.004f;
  ImageF depth(kSize, kSize), sigmas(kSize, kSize);
  SpreadNodes(nodes, node_sigmas, &depth, &sigmas);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const int far = std::max(std::abs(x - NodePixel(2)), std::abs(y - NodePixel(3)));
      if (far < kNodeSpacing / 2) {
        EXPECT_FLOAT_EQ(depth(x, y), 0.3f) << x << " " << y;
      } else if (far > kNodeSpacing / 2) {
        EXPECT_EQ(depth(x, y), 0) << x << " " << y;
      }
      EXPECT_EQ(sigmas(x, y) > 0, depth(x, y) > 0);
    }
  }
}

TEST(DepthFusion, NodesAreAveragedAndThoseThatAreAloneOrContradictedDropped) {
  ImageF nodes = NodesOf([](int, int) { return 0.3f; });
  ImageF node_sigmas(nodes.width(), nodes.height(), 0.004f);
  nodes(2, 2) = 0.31f;  // agrees
  nodes(4, 4) = 0.4f;   // does not
  ImageF fused = nodes, fused_sigmas = nodes;
  FuseNeighbours(nodes, node_sigmas, &fused, &fused_sigmas);
  EXPECT_EQ(fused(4, 4), 0);
  EXPECT_EQ(fused_sigmas(4, 4), 0);
  EXPECT_GT(fused(2, 2), 0.3f);
  EXPECT_LT(fused(2, 2), 0.305f);
  EXPECT_NEAR(fused_sigmas(2, 2), 0.004, 1e-6);
  EXPECT_FLOAT_EQ(fused(0, 0), 0.3f);

  ImageF lone(nodes.width(), nodes.height(), 0);
  lone(3, 3) = 0.3f;
  FuseNeighbours(lone, node_sigmas, &fused, &fused_sigmas);
  EXPECT_EQ(fused(3, 3), 0);
}

}  // namespace
}  // namespace prism
