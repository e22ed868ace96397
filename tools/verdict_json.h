// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "prism/lightfield/verdict.h"

namespace prism {

// Medians over the frames, as lightfield.json and run.json hold them.
inline nlohmann::ordered_json VerdictToJson(const LightFieldVerdict& verdict) {
  return {{"measured_fraction", verdict.MeasuredFraction()},
          {"noise", verdict.Noise()},
          {"misfit_noise", verdict.Misfit().noise},
          {"misfit_share_px", verdict.Misfit().share_px}};
}

}  // namespace prism
