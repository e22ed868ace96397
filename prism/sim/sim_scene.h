// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prism/sim/texture.h"

namespace prism {

// Triangles that share a texture. World frame: metres, z up. Front faces are counter-clockwise
// seen from outside.
struct SimMesh {
  struct Vertex {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  // unit length; used for lighting only
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();       // texture widths, heights
    Rgb shade = Rgb::Ones();  // reflectance factor; after BakeLighting radiance = shade * texture
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  int texture = 0;            // index into SimScene::textures
  bool double_sided = false;  // orientation of faces says nothing about inside and outside
};

// A square lamp that shines down; seen by surfaces, not by the camera.
struct SimLamp {
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  float size = 0.5f;   // side, m
  float power = 1.0f;  // irradiance straight below at 1 m
};

// Where the built-in trajectories take place.
struct SimPath {
  Eigen::Vector3d position = {0, 0, 1.5};  // start
  Eigen::Vector3d target = {1, 0, 1.5};    // looked at
  double extent = 0.5;                     // of the motion, m
};

struct SimScene {
  std::string name;
  std::vector<Texture> textures;
  std::vector<SimMesh> meshes;
  std::vector<SimLamp> lamps;
  Eigen::Vector3f sun_direction = Eigen::Vector3f::UnitZ();  // towards the sun, unit length
  float sun = 0;                                             // irradiance across its direction
  float ambient = 1;                                         // irradiance under an open sky
  Rgb background = Rgb::Zero();                              // radiance where nothing is hit
  SimPath path;
};

}  // namespace prism
