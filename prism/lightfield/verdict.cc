// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "prism/base/statistics.h"

namespace prism {

void LightFieldVerdict::Add(const ImageF& sigma, double noise, const MatchMisfit& misfit) {
  const auto measured =
      std::count_if(sigma.data(), sigma.data() + sigma.size(), [](float s) { return s > 0; });
  measured_.push_back(static_cast<double>(measured) / static_cast<double>(sigma.size()));
  noise_.push_back(noise);
  misfit_noise_.push_back(misfit.noise);
  misfit_share_.push_back(misfit.share_px);
}

double LightFieldVerdict::MeasuredFraction() const { return Quantile(measured_, 0.5); }

double LightFieldVerdict::Noise() const { return Quantile(noise_, 0.5); }

MatchMisfit LightFieldVerdict::Misfit() const {
  return {Quantile(misfit_noise_, 0.5), Quantile(misfit_share_, 0.5)};
}

bool LightFieldVerdict::IsUsable() const { return MeasuredFraction() >= 0.01; }

std::string LightFieldVerdict::Text() const {
  // On rendered frames lenses differ by the noise and texture is misplaced by 0.1 to 0.2 px; on
  // real ones that were compressed or resampled by up to 4 times the noise and 0.5 px.
  constexpr double kMuchNoise = 4;     // times its variance
  constexpr double kMuchShare = 0.35;  // px
  constexpr double kNoMatch = 0.6;     // px
  const MatchMisfit misfit = Misfit();
  char text[400];
  std::snprintf(
      text,
      sizeof(text),
      "light field of %zu frames (medians)\n"
      "  depth    at %.1f %% of the pixels (%.1f to %.1f)\n"
      "  noise    %.1f of 255; matching lenses differ by %.1f times that without texture\n"
      "  texture  misplaced by %.2f raw px from lens to lens\n",
      measured_.size(),
      100 * MeasuredFraction(),
      100 * Quantile(measured_, 0),
      100 * Quantile(measured_, 1),
      Noise(),
      std::sqrt(misfit.noise),
      misfit.share_px);
  std::string result = text;
  const bool is_no_match = misfit.share_px > kNoMatch;
  if (!IsUsable()) {
    result +=
        is_no_match
            ? "  hardly any depth, and lenses do not agree: another camera's grid, or another "
              "order of lens types\n"
            : "  hardly any depth: no texture in view, out of focus, or 1/v outside the range "
              "that is searched\n";
  } else if (is_no_match) {
    result +=
        "  lenses agree badly: the grid of another focus setting, or shaded micro images without a "
        "white image\n";
  } else if (misfit.share_px > kMuchShare || misfit.noise > kMuchNoise) {
    result +=
        "  lenses agree less well than in frames as they come from the sensor: compressed, "
        "resampled or sharpened?\n";
  }
  return result;
}

}  // namespace prism
