// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prism/sim/sim_scene.h"

namespace prism {

// How a surface gets its texture coordinates.
struct SurfaceStyle {
  // Metres that one repetition of the texture covers; 0 stretches it once over each face.
  Eigen::Vector2d texture_size = Eigen::Vector2d::Zero();
  Eigen::Vector2d uv_offset = Eigen::Vector2d::Zero();
  Rgb tint = Rgb::Ones();  // factor on the texture
};

// The builders add finely divided faces to a mesh, so that lighting can be stored at vertices.
// world_from_object places them; counter-clockwise faces point outwards.

// The parallelogram corner, corner + right, corner + right + down, corner + down; the texture's u
// runs along `right` and v along `down`. Its front is the side from which that order is clockwise.
void AddQuad(const Eigen::Vector3d& corner,
             const Eigen::Vector3d& right,
             const Eigen::Vector3d& down,
             const SurfaceStyle& style,
             SimMesh* mesh);

// A box that stands with the middle of its bottom at the object's origin; size (x, y, z). `inward`
// turns its faces inside (a room).
void AddBox(const Eigen::Isometry3d& world_from_object,
            const Eigen::Vector3d& size,
            const SurfaceStyle& style,
            SimMesh* mesh,
            bool inward = false);

// A cylinder or a cone's stump with caps, standing on the object's origin.
void AddCylinder(const Eigen::Isometry3d& world_from_object,
                 double bottom_radius,
                 double top_radius,
                 double height,
                 const SurfaceStyle& style,
                 SimMesh* mesh);

// A sphere about the object's origin.
void AddSphere(const Eigen::Isometry3d& world_from_object,
               double radius,
               const SurfaceStyle& style,
               SimMesh* mesh);

// A rotation about the vertical followed by a translation.
Eigen::Isometry3d Placement(const Eigen::Vector3d& position, double yaw_deg);

}  // namespace prism
