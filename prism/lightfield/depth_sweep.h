// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "prism/lightfield/lens_table.h"
#include "prism/lightfield/preparation.h"
#include "prism/lightfield/smooth_rows.h"

namespace prism {

struct SweepRange {
  float min_w, max_w;  // 1/v
  float step;
  // Chi square between the best match and any other more than two steps away, at least.
  float ambiguity;

  int count() const;  // of hypotheses, at most kMaxHypotheses
  static constexpr int kMaxHypotheses = 64;
};

struct SweepMinimum {
  float w;      // 1/v, to a fraction of a step
  float limit;  // the largest hypothesis at which there was something to compare
};

// The inverse virtual depth at which the lenses that see the virtual point (X, Y), undistorted raw
// px, agree best; nothing where the minimum is at an end of what lenses see of the range, or not
// the only one. `noise`: standard deviation of SmoothRows::smooth. Precondition: `rows` holds what
// PlaceSamples asks for, of all these views.
//
// All hypotheses are compared at the nearest half pixels and on every second row
// (SumCoarsePatchCosts); those that decide, around the minimum and wherever there could be another
// as low, are then compared exactly.
std::optional<SweepMinimum> SweepInverseVirtualDepth(const PreparedRaw& raw,
                                                     const SmoothRows& rows,
                                                     const LensTable& lenses,
                                                     const SweepRange& range,
                                                     float noise,
                                                     float X,
                                                     float Y);

}  // namespace prism
