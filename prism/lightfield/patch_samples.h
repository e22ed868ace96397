// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/lightfield/defocus_match.h"
#include "prism/lightfield/lens_table.h"
#include "prism/lightfield/patch_kernel.h"
#include "prism/lightfield/preparation.h"
#include "prism/lightfield/smooth_rows.h"

namespace prism {

// How far inside the image a view (LensTable::ViewsOf) has to be for the patch around it, raw px:
// the kernel reads kPatchLanes + 1 pixels a row.
inline constexpr float kPatchMargin = kPatchRadius + 8;

// The patches around `count` views, each blurred as `match` says. Precondition: `rows`, of
// raw.gray, holds those up to kPatchMargin around each view.
void PlaceSamples(const PreparedRaw& raw,
                  const SmoothRows& rows,
                  const LensTable& lenses,
                  const DefocusMatch& match,
                  const LensView* views,
                  int count,
                  PatchSample* samples);

// The same at the nearest half pixels.
void PlaceCoarseSamples(const PreparedRaw& raw,
                        const SmoothRows& rows,
                        const LensTable& lenses,
                        const DefocusMatch& match,
                        const LensView* views,
                        int count,
                        CoarseSample* samples);

}  // namespace prism
