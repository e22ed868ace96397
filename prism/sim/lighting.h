// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "prism/sim/ray_caster.h"
#include "prism/sim/sim_scene.h"

namespace prism {

// Multiplies every vertex' shade by the irradiance it gets from lamps, sun and ambient light with
// soft shadows and ambient occlusion (both sides of a surface are lit alike, as a matt one that is
// seen from the lit side). The light does not depend on the camera, so brightness is constant.
// Deterministic for a seed.
void BakeLighting(const RayCaster& caster, uint64_t seed, SimScene* scene);

}  // namespace prism
