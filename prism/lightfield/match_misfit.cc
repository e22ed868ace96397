// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/match_misfit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace prism {

MatchMisfit FitMisfit(std::vector<MatchSample> samples) {
  constexpr size_t kClasses = 8;
  constexpr size_t kMinPerClass = 20;
  // Lower quartile over median of a chi square of 6 degrees of freedom, about what is independent
  // in a patch.
  constexpr double kQuartileOverMedian = 0.65;
  constexpr double kMinNoise = 0.7, kMaxNoise = 12;
  constexpr double kMaxShare = 0.7;  // px; more is no match
  MatchMisfit misfit;
  if (samples.size() < kClasses * kMinPerClass) return misfit;
  std::sort(samples.begin(), samples.end(), [](const MatchSample& left, const MatchSample& right) {
    return left.contrast < right.contrast;
  });
  // Least squares of noise + share^2 contrast, relative to what is fitted.
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (size_t c = 0; c < kClasses; ++c) {
    const auto begin = samples.begin() + static_cast<std::ptrdiff_t>(c * samples.size() / kClasses);
    const auto end =
        samples.begin() + static_cast<std::ptrdiff_t>((c + 1) * samples.size() / kClasses);
    const double contrast = (begin + (end - begin) / 2)->contrast;
    const auto quartile = begin + (end - begin) / 4;
    std::nth_element(begin, quartile, end, [](const MatchSample& left, const MatchSample& right) {
      return left.residual < right.residual;
    });
    const double expected = std::max(quartile->residual / kQuartileOverMedian, 0.1);
    const Eigen::Vector2d row = Eigen::Vector2d(1, contrast) / expected;
    H += row * row.transpose();
    g += row;
  }
  const Eigen::Vector2d line = H.ldlt().solve(g);
  misfit.noise = std::clamp(line[0], kMinNoise, kMaxNoise);
  // The other one anew where the first met its bound.
  const double square = (g[1] - H(0, 1) * misfit.noise) / H(1, 1);
  misfit.share_px = std::sqrt(std::clamp(square, 0.0, kMaxShare * kMaxShare));
  return misfit;
}

}  // namespace prism
