// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/factors/window_graph.h"
#include "prism/solver/solve.h"

namespace prism {

struct WindowOptions {
  int max_keyframes = 8;  // optimised together, the newest among them
  int max_points = 2000;  // active, over all keyframes
  SolveOptions solve;
  WindowGraphOptions graph;
  bool marginalization_prior = true;  // false: what leaves the window is forgotten (ablation)

  bool IsValid(std::string* error) const;
};

}  // namespace prism
