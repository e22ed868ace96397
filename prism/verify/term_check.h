// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "prism/verify/jacobian_check.h"

namespace prism {

// The factors that terms have for random windows (three keyframes, points, a prior, the states that
// the terms add), each block of each against central differences. One entry a term and block.
std::vector<JacobianBlockCheck> CheckTerms(const PlenopticCamera& camera,
                                           const TermList& terms,
                                           const JacobianCheckOptions& options);

}  // namespace prism
