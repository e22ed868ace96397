// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_fusion.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

namespace prism {
namespace {

bool Agree(float w, float sigma, float other_w, float other_sigma) {
  return std::abs(w - other_w) < 2 * (sigma + other_sigma);
}

// The pixel between two nodes along one axis: the first of them and the share of the second.
struct Between {
  int node;
  float share;
};

Between BetweenNodes(int pixel) {
  const int node = (pixel + kNodeSpacing - kNodeSpacing / 2) / kNodeSpacing - 1;
  return {node, static_cast<float>(pixel - NodePixel(node)) / kNodeSpacing};
}

}  // namespace

void FuseNeighbours(const ImageF& nodes,
                    const ImageF& node_sigmas,
                    ImageF* fused,
                    ImageF* fused_sigmas) {
  constexpr float kSpacingSquared = kNodeSpacing * kNodeSpacing;
  tbb::parallel_for(0, nodes.height(), [&](int y) {
    for (int x = 0; x < nodes.width(); ++x) {
      const float w = nodes(x, y);
      (*fused)(x, y) = 0;
      (*fused_sigmas)(x, y) = 0;
      if (w == 0) continue;
      int agree = 0;
      int disagree = 0;
      float sum = 0;
      float sigma_sum = 0;
      float weight = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, nodes.height() - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, nodes.width() - 1); ++u) {
          const float other = nodes(u, v);
          if (other == 0) continue;
          const float sigma = node_sigmas(u, v);
          if (!Agree(other, sigma, w, node_sigmas(x, y))) {
            ++disagree;
            continue;
          }
          ++agree;
          const float far = kSpacingSquared * static_cast<float>(std::abs(u - x) + std::abs(v - y));
          const float information = 1 / (sigma * sigma * (1 + 0.25f * far));
          sum += information * other;
          sigma_sum += information * sigma;
          weight += information;
        }
      }
      if (agree < 2 || 2 * disagree > agree) continue;
      (*fused)(x, y) = sum / weight;
      (*fused_sigmas)(x, y) = sigma_sum / weight;
    }
  });
}

void SpreadNodes(const ImageF& nodes, const ImageF& node_sigmas, ImageF* depth, ImageF* sigmas) {
  constexpr float kLeastShare = 0.26f;  // more than that of a node 3/4 of the way to the next
  struct Node {
    float w, sigma;
    int right, below;  // of the four around
  };
  tbb::parallel_for(0, depth->height(), [&](int y) {
    const Between v = BetweenNodes(y);
    std::fill_n(depth->row(y), depth->width(), 0.0f);
    std::fill_n(sigmas->row(y), depth->width(), 0.0f);
    // Between two columns of nodes at a time: most have none.
    for (int left = BetweenNodes(0).node; NodePixel(left) < depth->width(); ++left) {
      Node around[4];
      int known = 0;
      for (int k = 0; k < 4; ++k) {
        const int i = left + k % 2;
        const int j = v.node + k / 2;
        if (!nodes.view().Contains(i, j, 0) || nodes(i, j) == 0) continue;
        around[known++] = {nodes(i, j), node_sigmas(i, j), k % 2, k / 2};
      }
      if (known == 0) continue;
      const int end = std::min(NodePixel(left + 1), depth->width());
      for (int x = std::max(NodePixel(left), 0); x < end; ++x) {
        const Between u = BetweenNodes(x);
        float share[4];
        const Node* best = nullptr;
        for (int k = 0; k < known; ++k) {
          share[k] = (around[k].right == 0 ? 1 - u.share : u.share) *
                     (around[k].below == 0 ? 1 - v.share : v.share);
          if (share[k] > 0 && (!best || around[k].sigma < best->sigma)) best = &around[k];
        }
        if (!best) continue;
        float sum = 0, variance = 0, total = 0;
        for (int k = 0; k < known; ++k) {
          if (!Agree(around[k].w, around[k].sigma, best->w, best->sigma)) continue;
          sum += share[k] * around[k].w;
          variance += share[k] * around[k].sigma * around[k].sigma;
          total += share[k];
        }
        if (total < kLeastShare) continue;
        (*depth)(x, y) = sum / total;
        (*sigmas)(x, y) = std::sqrt(variance / total);
      }
    }
  });
}

}  // namespace prism
