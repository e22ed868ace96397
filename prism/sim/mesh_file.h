// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "prism/sim/sim_scene.h"

namespace prism {

struct MeshFileOptions {
  Eigen::Isometry3d world_from_mesh = Eigen::Isometry3d::Identity();
  double scale = 1;  // metres a unit of the file
  // Used for materials without a texture of their own; -1: white.
  int texture = -1;
  // Faces are not trusted to tell inside from outside.
  bool double_sided = true;
};

// Adds the triangles of an OBJ, PLY or glTF file (assimp) to a scene, with the diffuse textures
// that it names beside it, or embeds, and vertex colours. Throws InputError naming the file if it
// does not load, holds no triangles, or a texture is missing or does not decode.
void AddMeshFile(const std::string& path, const MeshFileOptions& options, SimScene* scene);

// Decodes an image as a texture; InputError as above.
Texture ReadTexture(const std::string& path);

}  // namespace prism
