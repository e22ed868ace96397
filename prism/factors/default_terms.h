// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/factors/depth_offset_term.h"
#include "prism/factors/inverse_virtual_depth_term.h"
#include "prism/factors/photometric_term.h"
#include "prism/factors/term.h"

namespace prism {

// The terms every window has. Leaving one out is an ablation of what the paper claims.
struct DefaultTermOptions {
  PhotometricTermOptions photometric;
  InverseVirtualDepthTermOptions depth;
  DepthOffsetTermOptions depth_offset;
  bool depth_residual = true;
  bool robust_loss = true;  // false: squares in all of them

  bool IsValid(std::string* error) const;
};

TermList MakeDefaultTerms(const DefaultTermOptions& options);

}  // namespace prism
