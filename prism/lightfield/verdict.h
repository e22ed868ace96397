// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/image/image.h"
#include "prism/lightfield/match_misfit.h"

namespace prism {

// What can be said of the light field of a sequence without knowing the truth: how much depth there
// is, and how well lenses agree where there is some.
class LightFieldVerdict {
 public:
  // A frame's sigma of 1/v (0: not measured), noise of its raw image (0 to 255) and misfit.
  void Add(const ImageF& sigma, double noise, const MatchMisfit& misfit);

  bool empty() const { return measured_.empty(); }
  // Medians over the frames.
  double MeasuredFraction() const;
  double Noise() const;
  MatchMisfit Misfit() const;

  // Less than 1 % of the pixels have a depth: nothing can be done with it.
  bool IsUsable() const;
  // Some lines for people to read; what looks wrong stands at their end, with the likely reason.
  std::string Text() const;

 private:
  std::vector<double> measured_, noise_, misfit_noise_, misfit_share_;
};

}  // namespace prism
