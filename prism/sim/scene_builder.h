// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/sim/mesh_builder.h"
#include "prism/sim/sim_scene.h"

namespace prism {

// A texture of the scene and how it is laid on surfaces.
struct SurfaceTexture {
  int index = 0;  // into SimScene::textures
  SurfaceStyle style;
};

// The mesh of a scene that collects everything with one texture.
SimMesh* MeshOf(int texture, bool double_sided, SimScene* scene);

// A box in the scene; `tint` multiplies the texture's own.
void AddTexturedBox(const Eigen::Isometry3d& world_from_object,
                    const Eigen::Vector3d& size,
                    const SurfaceTexture& texture,
                    SimScene* scene,
                    const Rgb& tint = Rgb::Ones());

}  // namespace prism
