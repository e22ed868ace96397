// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/factors/term.h"

namespace prism {

// The window's marginalisation prior.
class MarginalizationPriorTerm : public Term {
 public:
  std::string name() const override { return "marginalization prior"; }
  void AddFactors(const Window& window, WindowGraph* graph) const override;
};

// The priors of states (StateBlock::prior_mean): what was known of them before any measurement.
class StatePriorTerm : public Term {
 public:
  std::string name() const override { return "state prior"; }
  void AddFactors(const Window& window, WindowGraph* graph) const override;
};

// Holds the gauge: a marginalisation prior that ties the only keyframe's state to where it is.
void AnchorFirstKeyframe(Window* window);

}  // namespace prism
