// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/scene_builder.h"

namespace prism {

SimMesh* MeshOf(int texture, bool double_sided, SimScene* scene) {
  for (SimMesh& mesh : scene->meshes) {
    if (mesh.texture == texture && mesh.double_sided == double_sided) return &mesh;
  }
  SimMesh mesh;
  mesh.texture = texture;
  mesh.double_sided = double_sided;
  scene->meshes.push_back(mesh);
  return &scene->meshes.back();
}

void AddTexturedBox(const Eigen::Isometry3d& world_from_object,
                    const Eigen::Vector3d& size,
                    const SurfaceTexture& texture,
                    SimScene* scene,
                    const Rgb& tint) {
  SurfaceStyle style = texture.style;
  style.tint *= tint;
  // Boxes of one texture do not all show the same part of it.
  const Eigen::Vector3d position = world_from_object.translation();
  if (style.texture_size.x() > 0) style.uv_offset += 1.37 * position.head<2>();
  AddBox(world_from_object, size, style, MeshOf(texture.index, false, scene));
}

}  // namespace prism
