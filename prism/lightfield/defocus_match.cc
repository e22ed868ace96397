// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/defocus_match.h"

#include <algorithm>

#include <glog/logging.h>

#include "prism/lightfield/smooth_rows.h"

namespace prism {

DefocusMatch::DefocusMatch(const std::vector<float>& focus, float defocus_variance, float w) {
  const int types = static_cast<int>(focus.size());
  DCHECK_LE(types, kMaxTypes);
  float variance[kMaxTypes] = {};
  for (int type = 0; type < types; ++type) {
    variance[type] = defocus_variance * (w - focus[type]) * (w - focus[type]);
  }
  const float least = *std::min_element(variance, variance + types);
  float most = least;
  for (int type = 0; type < types; ++type) {
    if (variance[type] - least <= kFilterVariance) most = std::max(most, variance[type]);
  }
  for (int type = 0; type < types; ++type) {
    blend_[type] = (most - variance[type]) / kFilterVariance;
    if (variance[type] <= most) types_ |= 1u << type;
  }
}

}  // namespace prism
