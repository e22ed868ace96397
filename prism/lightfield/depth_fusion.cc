// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_fusion.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <tbb/parallel_for.h>

namespace prism {
namespace {

bool Agree(float w, float sigma, float other_w, float other_sigma) {
  return std::abs(w - other_w) < 2 * (sigma + other_sigma);
}

// Rows of nodes, up or down, from a row of pixels to the last that may reach it.
int RowsToReach(const DepthNodes& nodes) {
  float farthest = 0;
  for (size_t i = 0; i < nodes.depth.size(); ++i) {
    if (nodes.depth.data()[i] == 0) continue;
    farthest = std::max(farthest, std::abs(nodes.shift_y.data()[i]) + nodes.reach.data()[i]);
  }
  return static_cast<int>(farthest / kNodeSpacing) + 1;
}

// Calls visit(x, w, sigma, weight) for every pixel x of row y that a node reaches.
template <typename Visit>
void ForEachInRow(const DepthNodes& nodes, int rows, int y, int width, const Visit& visit) {
  const int first = std::max(y / kNodeSpacing - rows, 0);
  const int last = std::min(y / kNodeSpacing + rows, nodes.height() - 1);
  for (int j = first; j <= last; ++j) {
    for (int i = 0; i < nodes.width(); ++i) {
      const float w = nodes.depth(i, j);
      if (w == 0) continue;
      const float reach = nodes.reach(i, j);
      const float v = static_cast<float>(NodePixel(j) - y) + nodes.shift_y(i, j);
      if (std::abs(v) >= reach) continue;
      const float center = static_cast<float>(NodePixel(i)) + nodes.shift_x(i, j);
      const int begin = std::max(static_cast<int>(std::floor(center - reach)) + 1, 0);
      const int end = std::min(static_cast<int>(std::ceil(center + reach)), width);
      for (int x = begin; x < end; ++x) {
        const float u = center - static_cast<float>(x);
        visit(x, w, nodes.sigma(i, j), (1 - std::abs(u) / reach) * (1 - std::abs(v) / reach));
      }
    }
  }
}

}  // namespace

DepthNodes::DepthNodes(int image_width, int image_height)
    : depth(NodesAlong(image_width), NodesAlong(image_height), 0),
      sigma(depth),
      shift_x(depth),
      shift_y(depth),
      reach(depth) {}

void FuseNeighbours(const DepthNodes& nodes, DepthNodes* fused) {
  constexpr float kSpacingSquared = kNodeSpacing * kNodeSpacing;
  tbb::parallel_for(0, nodes.height(), [&](int y) {
    for (int x = 0; x < nodes.width(); ++x) {
      const float w = nodes.depth(x, y);
      fused->depth(x, y) = 0;
      fused->sigma(x, y) = 0;
      fused->shift_x(x, y) = nodes.shift_x(x, y);
      fused->shift_y(x, y) = nodes.shift_y(x, y);
      fused->reach(x, y) = nodes.reach(x, y);
      if (w == 0) continue;
      int agree = 0;
      int disagree = 0;
      float sum = 0;
      float sigma_sum = 0;
      float weight = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, nodes.height() - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, nodes.width() - 1); ++u) {
          const float other = nodes.depth(u, v);
          if (other == 0) continue;
          const float sigma = nodes.sigma(u, v);
          if (!Agree(other, sigma, w, nodes.sigma(x, y))) {
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
      fused->depth(x, y) = sum / weight;
      fused->sigma(x, y) = sigma_sum / weight;
    }
  });
}

void SpreadNodes(const DepthNodes& nodes, ImageF* depth, ImageF* sigmas) {
  constexpr float kLeastWeight = 0.26f;  // of one node in its place
  const int rows = RowsToReach(nodes);
  tbb::parallel_for(0, depth->height(), [&](int y) {
    const int width = depth->width();
    float* w_row = depth->row(y);
    float* sigma_row = sigmas->row(y);
    std::fill_n(w_row, width, 0.0f);
    std::fill_n(sigma_row, width, 0.0f);
    ForEachInRow(nodes, rows, y, width, [&](int x, float w, float sigma, float) {
      if (w_row[x] != 0 && sigma_row[x] <= sigma) return;
      w_row[x] = w;
      sigma_row[x] = sigma;
    });
    struct Sum {
      float w = 0, variance = 0, weight = 0;
    };
    std::vector<Sum> sums(width);
    ForEachInRow(nodes, rows, y, width, [&](int x, float w, float sigma, float weight) {
      if (!Agree(w, sigma, w_row[x], sigma_row[x])) return;
      sums[x].w += weight * w;
      sums[x].variance += weight * sigma * sigma;
      sums[x].weight += weight;
    });
    for (int x = 0; x < width; ++x) {
      const bool is_known = sums[x].weight >= kLeastWeight;
      w_row[x] = is_known ? sums[x].w / sums[x].weight : 0;
      sigma_row[x] = is_known ? std::sqrt(sums[x].variance / sums[x].weight) : 0;
    }
  });
}

}  // namespace prism
