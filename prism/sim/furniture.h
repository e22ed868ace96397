// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "prism/sim/scene_builder.h"

namespace prism {

// Procedural furniture; world_from_object stands on the floor, its front towards -y, and sizes are
// (width x, depth y, height z) in metres. The same for the same seed.

// Boards of `frame` with rows of books and a few other things between them.
void AddBookshelf(const Eigen::Isometry3d& world_from_object,
                  const Eigen::Vector3d& size,
                  int shelves,
                  const SurfaceTexture& frame,
                  const SurfaceTexture& books,
                  uint64_t seed,
                  SimScene* scene);

// A table with `num_things` boxes, cans and balls of the textures of `things` on it.
void AddTable(const Eigen::Isometry3d& world_from_object,
              const Eigen::Vector3d& size,
              const SurfaceTexture& wood,
              const SurfaceTexture& things,
              int num_things,
              uint64_t seed,
              SimScene* scene);

void AddChair(const Eigen::Isometry3d& world_from_object,
              const SurfaceTexture& wood,
              const SurfaceTexture& seat,
              SimScene* scene);

// A sofa with cushions.
void AddSofa(const Eigen::Isometry3d& world_from_object,
             const Eigen::Vector3d& size,
             const SurfaceTexture& fabric,
             const SurfaceTexture& cushions,
             uint64_t seed,
             SimScene* scene);

// A potted plant of crossed leaf cards, `height` metres.
void AddPlant(const Eigen::Isometry3d& world_from_object,
              double height,
              const SurfaceTexture& pot,
              const SurfaceTexture& leaves,
              uint64_t seed,
              SimScene* scene);

// A wall of `floors` rows and `columns` columns of recessed windows, its front towards -y.
void AddFacade(const Eigen::Isometry3d& world_from_object,
               const Eigen::Vector3d& size,
               int columns,
               int floors,
               const SurfaceTexture& wall,
               const SurfaceTexture& frame,
               const SurfaceTexture& glass,
               SimScene* scene);

}  // namespace prism
