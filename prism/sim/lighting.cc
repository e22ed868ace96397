// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/lighting.h"

#include <cmath>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include "prism/sim/counter_random.h"

namespace prism {
namespace {

constexpr int kAmbientRays = 128;
constexpr int kLampSide = 4;                // strata along a lamp's side
constexpr float kOcclusionDistance = 2.0f;  // m; surfaces further off count as bright as the sky
constexpr float kOccludedAmbient = 0.35f;   // light that comes back from near surfaces
constexpr float kOffset = 2e-3f;            // m, rays start this far off the surface

float Irradiance(const RayCaster& caster,
                 const SimScene& scene,
                 const Eigen::Vector3f& position,
                 const Eigen::Vector3f& normal,
                 CounterRandom random) {
  const Eigen::Vector3f start = position + kOffset * normal;
  const Eigen::Vector3f tangent = normal.unitOrthogonal();
  const Eigen::Vector3f bitangent = normal.cross(tangent);
  float open = 0;
  const float turn = random.Uniform();
  for (int i = 0; i < kAmbientRays; ++i) {
    // Cosine-weighted directions on a spiral of the golden angle, turned at random: even, so that
    // blank walls do not get blotches.
    constexpr float kGoldenRatio = 0.618034f;
    const float r2 = (static_cast<float>(i) + 0.5f) / kAmbientRays;
    const float phi = 2 * static_cast<float>(M_PI) * (static_cast<float>(i) * kGoldenRatio + turn);
    const float r = std::sqrt(r2);
    const Eigen::Vector3f direction =
        r * (std::cos(phi) * tangent + std::sin(phi) * bitangent) + std::sqrt(1 - r2) * normal;
    open += caster.Occluded({start, direction}, 0, kOcclusionDistance) ? kOccludedAmbient : 1.0f;
  }
  float irradiance = scene.ambient * open / kAmbientRays;
  for (const SimLamp& lamp : scene.lamps) {
    for (int i = 0; i < kLampSide * kLampSide; ++i) {
      const int column = i % kLampSide, row = i / kLampSide;
      const float x = (static_cast<float>(column) + random.Uniform()) / kLampSide;
      const float y = (static_cast<float>(row) + random.Uniform()) / kLampSide;
      const Eigen::Vector3f point =
          lamp.center + lamp.size * Eigen::Vector3f(x - 0.5f, y - 0.5f, 0);
      const Eigen::Vector3f to_lamp = point - start;
      const float distance2 = to_lamp.squaredNorm();
      const float distance = std::sqrt(distance2);
      const float cos_surface = normal.dot(to_lamp) / distance;
      const float cos_lamp = to_lamp.z() / distance;  // it shines down
      if (cos_surface <= 0 || cos_lamp <= 0) continue;
      if (caster.Occluded({start, to_lamp}, 0, 0.999f)) continue;
      irradiance +=
          lamp.power * cos_surface * cos_lamp / std::max(distance2, 0.1f) / (kLampSide * kLampSide);
    }
  }
  const float cos_sun = normal.dot(scene.sun_direction);
  if (scene.sun > 0 && cos_sun > 0 && !caster.Occluded({start, scene.sun_direction}, 0, 1e4f)) {
    irradiance += scene.sun * cos_sun;
  }
  return irradiance;
}

}  // namespace

void BakeLighting(const RayCaster& caster, uint64_t seed, SimScene* scene) {
  for (size_t m = 0; m < scene->meshes.size(); ++m) {
    SimMesh& mesh = scene->meshes[m];
    tbb::parallel_for(size_t{0}, mesh.vertices.size(), [&](size_t i) {
      SimMesh::Vertex& vertex = mesh.vertices[i];
      vertex.shade *=
          Irradiance(caster, *scene, vertex.position, vertex.normal, CounterRandom(seed, m, i));
    });
  }
}

}  // namespace prism
