// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/mesh_builder.h"

#include <algorithm>
#include <cmath>

namespace prism {
namespace {

constexpr double kCellSize = 0.15;  // m between vertices that hold lighting
constexpr int kMaxCells = 48;       // a side

// Adds a (columns + 1) x (rows + 1) lattice of vertices and its triangles.
template <typename VertexAt>
void AddLattice(int columns, int rows, const VertexAt& vertex_at, SimMesh* mesh) {
  const uint32_t first = static_cast<uint32_t>(mesh->vertices.size());
  const uint32_t stride = static_cast<uint32_t>(columns) + 1;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      mesh->vertices.push_back(
          vertex_at(static_cast<double>(i) / columns, static_cast<double>(j) / rows));
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const uint32_t a = first + static_cast<uint32_t>(j) * stride + static_cast<uint32_t>(i);
      mesh->triangles.push_back({a, a + stride, a + 1});
      mesh->triangles.push_back({a + 1, a + stride, a + stride + 1});
    }
  }
}

int Cells(double length) {
  return static_cast<int>(std::clamp<double>(std::ceil(length / kCellSize), 1, kMaxCells));
}

Eigen::Vector2f TextureCoordinates(
    const SurfaceStyle& style, double s, double t, double width, double height) {
  Eigen::Vector2d uv(s, t);
  if (style.texture_size.x() > 0) {
    uv = {s * width / style.texture_size.x(), t * height / style.texture_size.y()};
  }
  return (uv + style.uv_offset).cast<float>();
}

}  // namespace

void AddQuad(const Eigen::Vector3d& corner,
             const Eigen::Vector3d& right,
             const Eigen::Vector3d& down,
             const SurfaceStyle& style,
             SimMesh* mesh) {
  const double width = right.norm();
  const double height = down.norm();
  const Eigen::Vector3f normal = down.cross(right).normalized().cast<float>();
  AddLattice(
      Cells(width),
      Cells(height),
      [&](double s, double t) {
        SimMesh::Vertex vertex;
        vertex.position = (corner + s * right + t * down).cast<float>();
        vertex.normal = normal;
        vertex.uv = TextureCoordinates(style, s, t, width, height);
        vertex.shade = style.tint;
        return vertex;
      },
      mesh);
}

void AddBox(const Eigen::Isometry3d& world_from_object,
            const Eigen::Vector3d& size,
            const SurfaceStyle& style,
            SimMesh* mesh,
            bool inward) {
  // Corner, right and down of each face seen from outside, in units of the size.
  const Eigen::Vector3d faces[6][3] = {
      {{-0.5, -0.5, 1}, {1, 0, 0}, {0, 0, -1}},  // -y
      {{0.5, 0.5, 1}, {-1, 0, 0}, {0, 0, -1}},   // +y
      {{-0.5, 0.5, 1}, {0, -1, 0}, {0, 0, -1}},  // -x
      {{0.5, -0.5, 1}, {0, 1, 0}, {0, 0, -1}},   // +x
      {{-0.5, 0.5, 1}, {1, 0, 0}, {0, -1, 0}},   // top
      {{-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}},   // bottom
  };
  for (const auto& face : faces) {
    Eigen::Vector3d corner = face[0].cwiseProduct(size);
    Eigen::Vector3d right = face[1].cwiseProduct(size);
    const Eigen::Vector3d down = face[2].cwiseProduct(size);
    if (inward) {
      corner += right;
      right = -right;
    }
    AddQuad(world_from_object * corner,
            world_from_object.linear() * right,
            world_from_object.linear() * down,
            style,
            mesh);
  }
}

void AddCylinder(const Eigen::Isometry3d& world_from_object,
                 double bottom_radius,
                 double top_radius,
                 double height,
                 const SurfaceStyle& style,
                 SimMesh* mesh) {
  const double girth = 2 * M_PI * std::max(bottom_radius, top_radius);
  const int sides = 24;
  const auto vertex_at = [&](double s, double t, double radius, double z, const auto& normal) {
    SimMesh::Vertex vertex;
    const double angle = 2 * M_PI * s;
    vertex.position =
        (world_from_object * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z))
            .template cast<float>();
    vertex.normal = (world_from_object.linear() * normal(angle)).template cast<float>();
    vertex.uv = TextureCoordinates(style, s, t, girth, height);
    vertex.shade = style.tint;
    return vertex;
  };
  const auto outward = [](double angle) {
    return Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  };
  AddLattice(
      sides,
      Cells(height),
      [&](double s, double t) {
        const double radius = top_radius + t * (bottom_radius - top_radius);
        return vertex_at(s, t, radius, height * (1 - t), outward);
      },
      mesh);
  const auto up = [](double) { return Eigen::Vector3d(0, 0, 1); };
  const auto down = [](double) { return Eigen::Vector3d(0, 0, -1); };
  AddLattice(
      sides,
      1,
      [&](double s, double t) { return vertex_at(s, t, t * top_radius, height, up); },
      mesh);
  AddLattice(
      sides,
      1,
      [&](double s, double t) { return vertex_at(s, t, (1 - t) * bottom_radius, 0, down); },
      mesh);
}

void AddSphere(const Eigen::Isometry3d& world_from_object,
               double radius,
               const SurfaceStyle& style,
               SimMesh* mesh) {
  AddLattice(
      32,
      16,
      [&](double s, double t) {
        const double azimuth = 2 * M_PI * s;
        const double polar = M_PI * t;
        const Eigen::Vector3d normal(std::sin(polar) * std::cos(azimuth),
                                     std::sin(polar) * std::sin(azimuth),
                                     std::cos(polar));
        SimMesh::Vertex vertex;
        vertex.position = (world_from_object * (radius * normal)).cast<float>();
        vertex.normal = (world_from_object.linear() * normal).cast<float>();
        vertex.uv = TextureCoordinates(style, s, t, 2 * M_PI * radius, M_PI * radius);
        vertex.shade = style.tint;
        return vertex;
      },
      mesh);
}

Eigen::Isometry3d Placement(const Eigen::Vector3d& position, double yaw_deg) {
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  placement.translate(position);
  placement.rotate(Eigen::AngleAxisd(yaw_deg * M_PI / 180, Eigen::Vector3d::UnitZ()));
  return placement;
}

}  // namespace prism
