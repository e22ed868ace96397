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
  constexpr float kLeastShare = 0.26f;  // more than that of a node 3 px away
  tbb::parallel_for(0, depth->height(), [&](int y) {
    const Between v = BetweenNodes(y);
    for (int x = 0; x < depth->width(); ++x) {
      const Between u = BetweenNodes(x);
      float w[4], sigma[4], share[4];
      int count = 0, best = 0;
      for (int k = 0; k < 4; ++k) {
        const int i = u.node + k % 2;
        const int j = v.node + k / 2;
        if (!nodes.view().Contains(i, j, 0) || nodes(i, j) == 0) continue;
        share[count] = (k % 2 == 0 ? 1 - u.share : u.share) * (k / 2 == 0 ? 1 - v.share : v.share);
        if (share[count] == 0) continue;
        w[count] = nodes(i, j);
        sigma[count] = node_sigmas(i, j);
        if (sigma[count] < sigma[best]) best = count;
        ++count;
      }
      float sum = 0, variance = 0, total = 0;
      for (int k = 0; k < count; ++k) {
        if (!Agree(w[k], sigma[k], w[best], sigma[best])) continue;
        sum += share[k] * w[k];
        variance += share[k] * sigma[k] * sigma[k];
        total += share[k];
      }
      const bool is_known = total >= kLeastShare;
      (*depth)(x, y) = is_known ? sum / total : 0;
      (*sigmas)(x, y) = is_known ? std::sqrt(variance / total) : 0;
    }
  });
}

}  // namespace prism
