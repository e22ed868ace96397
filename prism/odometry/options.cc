// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/options.h"

#include <algorithm>
#include <set>

namespace prism {

namespace {

bool HaveDistinctNames(const OdometryOptions& options) {
  std::set<std::string> names;
  size_t count = 0;
  for (const TermList& terms : {MakeDefaultTerms(options.default_terms), options.terms}) {
    for (const auto& term : terms) names.insert(term->name());
    count += terms.size();
  }
  return names.size() == count;
}

}  // namespace

bool OdometryOptions::IsValid(std::string* error) const {
  if (!activation.IsValid(error) || !tracker.IsValid(error) || !keyframe.IsValid(error) ||
      !window.IsValid(error) || !retirement.IsValid(error) || !joining.IsValid(error) ||
      !default_terms.IsValid(error)) {
    return false;
  }
  if (std::any_of(terms.begin(), terms.end(), [](const auto& term) { return term == nullptr; })) {
    *error = "a term that is null";
  } else if (!HaveDistinctNames(*this)) {
    *error = "two terms of one name";
  } else if (!(photometric_model_sigma > 0)) {
    *error = "a photometric model error of " + std::to_string(photometric_model_sigma) +
             ", expected above 0";
  } else if (min_start_points < 10 || max_lost_frames < 1) {
    *error = "odometry needs 10 points or more to start, and a lost frame or more before it does";
  } else {
    return true;
  }
  return false;
}

}  // namespace prism
