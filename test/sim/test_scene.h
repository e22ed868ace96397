// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <glog/logging.h>
#include <Eigen/Geometry>

#include "prism/io/camera_file.h"
#include "prism/sim/mesh_builder.h"
#include "prism/sim/sim_scene.h"

namespace prism {

inline PlenopticCamera SmallCamera() {
  return ReadPlenopticCamera(std::string(PRISM_SOURCE_DIR) + "/test/sim/small_camera.yaml");
}

// An empty scene whose only texture is white, so that a surface's radiance is its tint.
inline SimScene WhiteScene() {
  SimScene scene;
  scene.textures.emplace_back(cv::Mat(1, 1, CV_8UC1, cv::Scalar(255)));
  scene.meshes.emplace_back();
  return scene;
}

// Adds a shining parallelogram about `center`.
inline void AddPatch(const Eigen::Vector3d& center,
                     const Eigen::Vector3d& right,
                     const Eigen::Vector3d& down,
                     SimScene* scene) {
  AddQuad(center - 0.5 * (right + down), right, down, SurfaceStyle(), &scene->meshes[0]);
}

}  // namespace prism
