// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "prism/export/export_run.h"
#include "test/map/speckle_texture.h"

namespace prism {

inline constexpr double kWallDepth = 1.5;  // m; the wall z = kWallDepth of the world
inline constexpr int kSampleKeyframes = 6;

inline PlenopticProjection SampleCamera() {
  PlenopticProjection camera;
  camera.f = 0.016;
  camera.b_L0 = 0.0152;
  camera.B = 0.000375;
  camera.s = 0.00004;  // 400 px
  camera.c = {161.3, 118.9};
  camera.width = 320;
  camera.height = 240;
  return camera;
}

// The wall as the pinhole at the front focal point sees it, with a factor on its brightness.
inline LightFieldFrame ViewOfWall(const PlenopticProjection& camera,
                                  const SE3& world_from_cam,
                                  double gain) {
  LightFieldFrame frame;
  ImageF image(camera.width, camera.height);
  frame.inverse_virtual_depth = ImageF(camera.width, camera.height, 0);
  frame.sigma = ImageF(camera.width, camera.height, 0);
  const SE3 world_from_pinhole = WorldFromPinhole(camera, world_from_cam);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d m = (Eigen::Vector2d(x, y) - camera.c) / camera.FocalLengthPx();
      const Eigen::Vector3d ray =
          world_from_pinhole.RotationMatrix() * Eigen::Vector3d(m.x(), m.y(), 1);
      const Eigen::Vector3d start = world_from_pinhole.translation();
      const double zeta = (kWallDepth - start.z()) / ray.z();
      const Eigen::Vector3d p = start + zeta * ray;
      image(x, y) = static_cast<float>(std::min(gain * SpeckleTexture(p.x(), p.y()), 255.0));
      frame.inverse_virtual_depth(x, y) =
          static_cast<float>(InverseVirtualDepth(camera, 1 / (zeta + camera.f)));
      frame.sigma(x, y) = 0.002f;
    }
  }
  frame.image.push_back(std::move(image));
  return frame;
}

// A camera that walks along a textured wall, each picture of another exposure, all poses, depths
// and points exact.
inline ExportRun SampleRun() {
  ExportRun run;
  run.camera = SampleCamera();
  for (int i = 0; i < kSampleKeyframes; ++i) {
    ExportKeyframe keyframe;
    keyframe.id = 3 * i;
    keyframe.time_ns = 1700000000000000000 + 200000000LL * i;
    Vector6d motion;
    motion << 0.05 * i, 0.01 * i, 0.01 * i, 0.004 * i, -0.01 * i, 0.006 * i;
    keyframe.world_from_cam = SE3::Exp(motion);
    EncodeFrame(ViewOfWall(run.camera, keyframe.world_from_cam, 0.85 + 0.05 * i), &keyframe);
    run.trajectory.push_back({keyframe.time_ns, keyframe.world_from_cam});
    run.trajectory.push_back({keyframe.time_ns + 100000000, SE3::Exp(motion * 1.01)});
    const SE3 pinhole = WorldFromPinhole(run.camera, keyframe.world_from_cam);
    for (int y = 30; y < run.camera.height - 30; y += 20) {
      for (int x = 30; x < run.camera.width - 30; x += 20) {
        const Eigen::Vector2d px(x, y);
        const Eigen::Vector2d m = (px - run.camera.c) / run.camera.FocalLengthPx();
        const Eigen::Vector3d ray = pinhole.RotationMatrix() * Eigen::Vector3d(m.x(), m.y(), 1);
        const double zeta = (kWallDepth - pinhole.translation().z()) / ray.z();
        const Eigen::Vector3d p = pinhole.translation() + zeta * ray;
        run.points.push_back({p, {10, 20, 30}, keyframe.id, px, 0.01});
      }
    }
    run.keyframes.push_back(std::move(keyframe));
  }
  return run;
}

}  // namespace prism
