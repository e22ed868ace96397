// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/depth_support.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace prism {

DepthSupport::DepthSupport(const PlenopticProjection& camera, const LightFieldFrame& frame)
    : frame_(frame),
      towards_camera_(camera.B > 0 ? -1.0f : 1.0f),
      local_(frame.sigma.width(), frame.sigma.height()) {}

bool DepthSupport::IsSupported(int x, int y) const {
  constexpr int kRadius = 2;              // px
  constexpr int kMinMeasured = 5;         // fewer say nothing
  constexpr double kMaxDifference = 3.5;  // standard deviations
  constexpr double kMinAgreeing = 0.35;
  const double w = frame_.inverse_virtual_depth(x, y), sigma = frame_.sigma(x, y);
  int measured = 0, agreeing = 0;
  for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, frame_.sigma.height() - 1);
       ++v) {
    for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, frame_.sigma.width() - 1);
         ++u) {
      const double other = frame_.sigma(u, v);
      if (other == 0 || (u == x && v == y)) continue;
      ++measured;
      agreeing += std::abs(frame_.inverse_virtual_depth(u, v) - w) <
                  kMaxDifference * std::hypot(sigma, other);
    }
  }
  return measured < kMinMeasured || agreeing >= kMinAgreeing * measured;
}

bool DepthSupport::IsBesideNearer(int x, int y) {
  constexpr int kReach = 4;        // px
  constexpr float kMinSigmas = 3;  // of the difference
  const LocalDepth& here = DepthAround(x, y);
  if (here.variance < 0) return false;
  for (int v = y - kReach; v <= y + kReach; v += kReach) {
    for (int u = x - kReach; u <= x + kReach; u += kReach) {
      if (u < 0 || v < 0 || u >= local_.width() || v >= local_.height()) continue;
      const LocalDepth& there = DepthAround(u, v);
      if (there.variance < 0) continue;
      const float nearer = towards_camera_ * (there.w - here.w);
      if (nearer > kMinSigmas * std::sqrt(here.variance + there.variance)) return true;
    }
  }
  return false;
}

const DepthSupport::LocalDepth& DepthSupport::DepthAround(int x, int y) {
  LocalDepth& depth = local_(x, y);
  if (depth.variance != 0) return depth;
  std::array<float, 9> measured;
  int count = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, local_.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, local_.width() - 1); ++u) {
      const float sigma = frame_.sigma(u, v);
      if (sigma == 0) continue;
      measured[count++] = frame_.inverse_virtual_depth(u, v);
      depth.variance += sigma * sigma;
    }
  }
  if (count == 0) {
    depth.variance = -1;
    return depth;
  }
  const auto middle = measured.begin() + count / 2;
  std::nth_element(measured.begin(), middle, measured.begin() + count);
  depth.w = *middle;
  const bool is_correlated = frame_.depth_correlation_px > 0;
  depth.variance /= static_cast<float>(is_correlated ? count : count * count);
  return depth;
}

}  // namespace prism
