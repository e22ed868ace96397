// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <Eigen/Core>

#include "prism/sim/sim_scene.h"

namespace prism {

// A ray in world coordinates; points are origin + t direction, direction of any length, so that t
// is the depth z_C for a camera-frame direction with z = 1.
struct SimRay {
  Eigen::Vector3f origin;
  Eigen::Vector3f direction;
};

struct SimHit {
  int mesh = -1;  // -1: nothing was hit
  int triangle = 0;
  float t = 0;
  float u = 0;  // barycentric: vertex 0 has weight 1 - u - v, 1 has u, 2 has v
  float v = 0;
  bool back_face = false;

  bool found() const { return mesh >= 0; }
};

// First hits of rays in a scene (Embree). The scene's triangles and textures must outlive it and
// keep their positions; shades may change. Thread-safe.
class RayCaster {
 public:
  explicit RayCaster(const SimScene& scene);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  // The first hit with t > t_min.
  SimHit Cast(const SimRay& ray, float t_min = 0) const;

  // Four rays at once; those not wanted (mask) give a hit that is not found.
  void Cast4(const SimRay rays[4], const bool mask[4], float t_min, SimHit hits[4]) const;

  // Whether anything is hit for t in (t_min, t_max).
  bool Occluded(const SimRay& ray, float t_min, float t_max) const;

  // t of the hit triangle's plane along the ray in double precision.
  double PreciseDepth(const SimHit& hit,
                      const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction) const;

  // What is seen at a hit (or the background). `footprint` is the side of the surface patch the ray
  // stands for, in metres across the ray.
  Rgb Radiance(const SimHit& hit, float footprint) const;

  // Whether a point is inside an object: of 26 directions around it most hit a surface from its
  // back, not counting double-sided meshes.
  bool IsInside(const Eigen::Vector3d& point) const;

  // Distance to the nearest surface seen in 26 directions, metres; infinity if none.
  double Clearance(const Eigen::Vector3d& point) const;

 private:
  struct Embree;
  const SimScene& scene_;
  std::unique_ptr<Embree> embree_;
  std::vector<float> uv_per_metre_;  // of each mesh, in texture widths
};

}  // namespace prism
