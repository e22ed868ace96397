// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/options.h"

namespace prism {

bool WindowOptions::IsValid(std::string* error) const {
  if (max_keyframes < 3) {
    *error = "a window of " + std::to_string(max_keyframes) + " keyframes, expected 3 or more";
  } else if (max_points < 50) {
    *error = std::to_string(max_points) + " active points, expected 50 or more";
  } else {
    return solve.IsValid(error);
  }
  return false;
}

}  // namespace prism
