// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/ray_caster.h"

#include <cmath>
#include <limits>

#if PRISM_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <glog/logging.h>
#include <Eigen/Geometry>

namespace prism {
namespace {

// Texture widths a metre of surface, from the areas of a mesh.
float UvPerMetre(const SimMesh& mesh) {
  double area = 0;
  double uv_area = 0;
  for (const auto& t : mesh.triangles) {
    const auto& a = mesh.vertices[t[0]];
    const auto& b = mesh.vertices[t[1]];
    const auto& c = mesh.vertices[t[2]];
    area += (b.position - a.position).cross(c.position - a.position).norm();
    const Eigen::Vector2f e = b.uv - a.uv;
    const Eigen::Vector2f f = c.uv - a.uv;
    uv_area += std::abs(e.x() * f.y() - e.y() * f.x());
  }
  return area > 0 ? static_cast<float>(std::sqrt(uv_area / area)) : 0.0f;
}

template <typename Function>
void ForEachDirection(const Function& function) {
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        // Slightly off the axes, where edges of boxes tend to be.
        function(Eigen::Vector3f(x + 0.013f, y + 0.007f, z + 0.011f).normalized());
      }
    }
  }
}

// Queries of one ray or four; version 3 wants a context, version 4 has none.
#if PRISM_EMBREE_MAJOR >= 4
void Intersect1(RTCScene scene, RTCRayHit* query) { rtcIntersect1(scene, query); }
void Intersect4(const int* valid, RTCScene scene, RTCRayHit4* query) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect4(valid, scene, query, &arguments);
}
void Occluded1(RTCScene scene, RTCRay* query) { rtcOccluded1(scene, query); }
#else
RTCIntersectContext NewContext() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return context;
}
void Intersect1(RTCScene scene, RTCRayHit* query) {
  RTCIntersectContext context = NewContext();
  rtcIntersect1(scene, &context, query);
}
void Intersect4(const int* valid, RTCScene scene, RTCRayHit4* query) {
  RTCIntersectContext context = NewContext();
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect4(valid, scene, &context, query);
}
void Occluded1(RTCScene scene, RTCRay* query) {
  RTCIntersectContext context = NewContext();
  rtcOccluded1(scene, &context, query);
}
#endif

}  // namespace

struct RayCaster::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

RayCaster::RayCaster(const SimScene& scene) : scene_(scene), embree_(new Embree) {
  embree_->device = rtcNewDevice(nullptr);
  CHECK(embree_->device != nullptr) << "Embree: error " << rtcGetDeviceError(nullptr);
  embree_->scene = rtcNewScene(embree_->device);
  rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(embree_->scene, RTC_BUILD_QUALITY_HIGH);
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const SimMesh& mesh = scene.meshes[i];
    RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry,
                               RTC_BUFFER_TYPE_VERTEX,
                               0,
                               RTC_FORMAT_FLOAT3,
                               mesh.vertices.data(),
                               offsetof(SimMesh::Vertex, position),
                               sizeof(SimMesh::Vertex),
                               mesh.vertices.size());
    rtcSetSharedGeometryBuffer(geometry,
                               RTC_BUFFER_TYPE_INDEX,
                               0,
                               RTC_FORMAT_UINT3,
                               mesh.triangles.data(),
                               0,
                               sizeof(mesh.triangles[0]),
                               mesh.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(embree_->scene, geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);
    uv_per_metre_.push_back(UvPerMetre(mesh));
  }
  rtcCommitScene(embree_->scene);
}

RayCaster::~RayCaster() {
  rtcReleaseScene(embree_->scene);
  rtcReleaseDevice(embree_->device);
}

SimHit RayCaster::Cast(const SimRay& ray, float t_min) const {
  RTCRayHit query{};
  query.ray.org_x = ray.origin.x();
  query.ray.org_y = ray.origin.y();
  query.ray.org_z = ray.origin.z();
  query.ray.dir_x = ray.direction.x();
  query.ray.dir_y = ray.direction.y();
  query.ray.dir_z = ray.direction.z();
  query.ray.tnear = t_min;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = ~0u;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  Intersect1(embree_->scene, &query);
  SimHit hit;
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
  hit.mesh = static_cast<int>(query.hit.geomID);
  hit.triangle = static_cast<int>(query.hit.primID);
  hit.t = query.ray.tfar;
  hit.u = query.hit.u;
  hit.v = query.hit.v;
  const Eigen::Vector3f normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  hit.back_face = normal.dot(ray.direction) > 0;
  return hit;
}

void RayCaster::Cast4(const SimRay rays[4], const bool mask[4], float t_min, SimHit hits[4]) const {
  alignas(16) int valid[4];
  RTCRayHit4 query{};
  for (int i = 0; i < 4; ++i) {
    hits[i] = SimHit();
    valid[i] = mask[i] ? -1 : 0;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    if (!mask[i]) continue;
    query.ray.org_x[i] = rays[i].origin.x();
    query.ray.org_y[i] = rays[i].origin.y();
    query.ray.org_z[i] = rays[i].origin.z();
    query.ray.dir_x[i] = rays[i].direction.x();
    query.ray.dir_y[i] = rays[i].direction.y();
    query.ray.dir_z[i] = rays[i].direction.z();
    query.ray.tnear[i] = t_min;
    query.ray.tfar[i] = std::numeric_limits<float>::infinity();
    query.ray.mask[i] = ~0u;
  }
  Intersect4(valid, embree_->scene, &query);
  for (int i = 0; i < 4; ++i) {
    if (!mask[i] || query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    hits[i].mesh = static_cast<int>(query.hit.geomID[i]);
    hits[i].triangle = static_cast<int>(query.hit.primID[i]);
    hits[i].t = query.ray.tfar[i];
    hits[i].u = query.hit.u[i];
    hits[i].v = query.hit.v[i];
  }
}

bool RayCaster::Occluded(const SimRay& ray, float t_min, float t_max) const {
  RTCRay query{};
  query.org_x = ray.origin.x();
  query.org_y = ray.origin.y();
  query.org_z = ray.origin.z();
  query.dir_x = ray.direction.x();
  query.dir_y = ray.direction.y();
  query.dir_z = ray.direction.z();
  query.tnear = t_min;
  query.tfar = t_max;
  query.mask = ~0u;
  Occluded1(embree_->scene, &query);
  return query.tfar < 0;
}

double RayCaster::PreciseDepth(const SimHit& hit,
                               const Eigen::Vector3d& origin,
                               const Eigen::Vector3d& direction) const {
  const SimMesh& mesh = scene_.meshes[hit.mesh];
  const auto& corners = mesh.triangles[hit.triangle];
  const Eigen::Vector3d a = mesh.vertices[corners[0]].position.cast<double>();
  const Eigen::Vector3d b = mesh.vertices[corners[1]].position.cast<double>();
  const Eigen::Vector3d c = mesh.vertices[corners[2]].position.cast<double>();
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  return normal.dot(a - origin) / normal.dot(direction);
}

Rgb RayCaster::Radiance(const SimHit& hit, float footprint) const {
  if (!hit.found()) return scene_.background;
  const SimMesh& mesh = scene_.meshes[hit.mesh];
  const auto& corners = mesh.triangles[hit.triangle];
  const auto& a = mesh.vertices[corners[0]];
  const auto& b = mesh.vertices[corners[1]];
  const auto& c = mesh.vertices[corners[2]];
  const float w = 1 - hit.u - hit.v;
  const Eigen::Vector2f uv = w * a.uv + hit.u * b.uv + hit.v * c.uv;
  const Rgb shade = w * a.shade + hit.u * b.shade + hit.v * c.shade;
  return shade *
         scene_.textures[mesh.texture].Sample(uv.x(), uv.y(), footprint * uv_per_metre_[hit.mesh]);
}

bool RayCaster::IsInside(const Eigen::Vector3d& point) const {
  int from_the_back = 0;
  ForEachDirection([&](const Eigen::Vector3f& direction) {
    const SimHit hit = Cast({point.cast<float>(), direction});
    if (hit.found() && hit.back_face && !scene_.meshes[hit.mesh].double_sided) ++from_the_back;
  });
  return from_the_back > 13;
}

double RayCaster::Clearance(const Eigen::Vector3d& point) const {
  double clearance = std::numeric_limits<double>::infinity();
  ForEachDirection([&](const Eigen::Vector3f& direction) {
    const SimHit hit = Cast({point.cast<float>(), direction});
    if (hit.found()) clearance = std::min<double>(clearance, hit.t);
  });
  return clearance;
}

}  // namespace prism
