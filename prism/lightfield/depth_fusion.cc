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

}  // namespace

void FillBetween(ImageF* depth, ImageF* sigmas) {
  tbb::parallel_for(0, depth->height(), [&](int y) {
    for (int x = (y + 1) % 2; x < depth->width(); x += 2) {
      (*depth)(x, y) = 0;
      (*sigmas)(x, y) = 0;
      if (x == 0 || y == 0 || x + 1 == depth->width() || y + 1 == depth->height()) continue;
      const float w[4] = {
          (*depth)(x - 1, y), (*depth)(x + 1, y), (*depth)(x, y - 1), (*depth)(x, y + 1)};
      const float sigma[4] = {
          (*sigmas)(x - 1, y), (*sigmas)(x + 1, y), (*sigmas)(x, y - 1), (*sigmas)(x, y + 1)};
      int best = -1;
      for (int k = 0; k < 4; ++k) {
        if (w[k] > 0 && (best < 0 || sigma[k] < sigma[best])) best = k;
      }
      if (best < 0) continue;
      int count = 0;
      float sum = 0;
      float variance = 0;
      for (int k = 0; k < 4; ++k) {
        if (w[k] == 0 || !Agree(w[k], sigma[k], w[best], sigma[best])) continue;
        ++count;
        sum += w[k];
        variance += sigma[k] * sigma[k];
      }
      if (count < 2) continue;
      (*depth)(x, y) = sum / static_cast<float>(count);
      (*sigmas)(x, y) = std::sqrt(variance / static_cast<float>(count));
    }
  });
}

void FuseNeighbours(const ImageF& depth,
                    const ImageF& sigmas,
                    ImageF* fused,
                    ImageF* fused_sigmas) {
  constexpr int kReach = 3;
  tbb::parallel_for(0, depth.height(), [&](int y) {
    for (int x = 0; x < depth.width(); ++x) {
      const float w = depth(x, y);
      (*fused)(x, y) = 0;
      (*fused_sigmas)(x, y) = 0;
      if (w == 0) continue;
      int agree = 0;
      int disagree = 0;
      float sum = 0;
      float sigma_sum = 0;
      float weight = 0;
      for (int v = std::max(y - kReach, 0); v <= std::min(y + kReach, depth.height() - 1); ++v) {
        for (int u = std::max(x - kReach, 0); u <= std::min(x + kReach, depth.width() - 1); ++u) {
          const float other = depth(u, v);
          if (other == 0) continue;
          const float sigma_other = sigmas(u, v);
          if (Agree(other, sigma_other, w, sigmas(x, y))) {
            ++agree;
            const float far = static_cast<float>((u - x) * (u - x) + (v - y) * (v - y));
            const float information = 1 / (sigma_other * sigma_other * (1 + 0.25f * far));
            sum += information * other;
            sigma_sum += information * sigma_other;
            weight += information;
          } else {
            ++disagree;
          }
        }
      }
      if (agree < 8 || 2 * disagree > agree) continue;
      (*fused)(x, y) = sum / weight;
      (*fused_sigmas)(x, y) = sigma_sum / weight;
    }
  });
}

}  // namespace prism
