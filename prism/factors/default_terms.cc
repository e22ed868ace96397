// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/default_terms.h"

#include "prism/factors/prior_term.h"

namespace prism {

bool DefaultTermOptions::IsValid(std::string* error) const {
  return photometric.IsValid(error) && depth.IsValid(error) && depth_offset.IsValid(error);
}

TermList MakeDefaultTerms(const DefaultTermOptions& options) {
  PhotometricTermOptions photometric = options.photometric;
  InverseVirtualDepthTermOptions depth = options.depth;
  if (!options.robust_loss) photometric.cauchy = depth.huber = 0;
  TermList terms = {std::make_shared<PhotometricTerm>(photometric)};
  if (options.depth_residual) {
    terms.push_back(std::make_shared<InverseVirtualDepthTerm>(depth));
    if (options.depth_offset.has_persistent() || options.depth_offset.per_keyframe) {
      terms.push_back(std::make_shared<DepthOffsetTerm>(options.depth_offset));
    }
  }
  terms.push_back(std::make_shared<StatePriorTerm>());
  terms.push_back(std::make_shared<MarginalizationPriorTerm>());
  return terms;
}

}  // namespace prism
