// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/furniture.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "prism/base/random.h"

namespace prism {
namespace {

class Dice {
 public:
  explicit Dice(uint64_t seed) : generator_(SeededGenerator(seed, 0)) {}
  double operator()(double low, double high) {
    return low + (high - low) * 0x1p-64 * static_cast<double>(generator_());
  }
  // A factor on a texture: mostly brightness, some colour.
  Rgb Tint(double low) {
    const double gray = (*this)(low, 1.0);
    const double red = gray * (*this)(0.8, 1.2);
    const double green = gray * (*this)(0.8, 1.1);
    const double blue = gray * (*this)(0.7, 1.1);
    return Eigen::Array3d(red, green, blue).cast<float>();
  }

 private:
  std::mt19937_64 generator_;
};

// A box given by the middle of its bottom in the object's frame.
void Part(const Eigen::Isometry3d& world_from_object,
          const Eigen::Vector3d& at,
          const Eigen::Vector3d& size,
          const SurfaceTexture& texture,
          SimScene* scene,
          const Rgb& tint = Rgb::Ones(),
          double yaw_deg = 0) {
  AddTexturedBox(world_from_object * Placement(at, yaw_deg), size, texture, scene, tint);
}

void Legs(const Eigen::Isometry3d& world_from_object,
          double width,
          double depth,
          double height,
          const SurfaceTexture& wood,
          SimScene* scene) {
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      Part(world_from_object, {x * width, y * depth, 0}, {0.05, 0.05, height}, wood, scene);
    }
  }
}

}  // namespace

void AddBookshelf(const Eigen::Isometry3d& world_from_object,
                  const Eigen::Vector3d& size,
                  int shelves,
                  const SurfaceTexture& frame,
                  const SurfaceTexture& books,
                  uint64_t seed,
                  SimScene* scene) {
  constexpr double kBoard = 0.025;
  Dice dice(seed);
  const double w = size.x();
  const double d = size.y();
  const double h = size.z();
  for (const double side : {-0.5, 0.5}) {
    Part(world_from_object, {side * (w - kBoard), 0, 0}, {kBoard, d, h}, frame, scene);
  }
  Part(world_from_object, {0, 0.5 * d - 0.01, 0}, {w - 2 * kBoard, 0.01, h}, frame, scene);
  const double pitch = (h - kBoard) / shelves;
  for (int shelf = 0; shelf <= shelves; ++shelf) {
    Part(world_from_object, {0, 0, shelf * pitch}, {w - 2 * kBoard, d, kBoard}, frame, scene);
    if (shelf == shelves) break;
    double x = -0.5 * w + 1.5 * kBoard;
    while (x < 0.5 * w - 2 * kBoard) {
      if (dice(0, 1) < 0.12) {  // a gap
        x += dice(0.05, 0.2);
        continue;
      }
      const double thickness = std::min(dice(0.02, 0.055), 0.5 * w - 1.5 * kBoard - x);
      const double height = std::min(dice(0.6, 0.92) * (pitch - kBoard), 0.34);
      const double depth = d * dice(0.55, 0.8);
      Part(world_from_object,
           {x + 0.5 * thickness, 0.5 * (d - depth) - 0.03, shelf * pitch + kBoard},
           {thickness - 0.003, depth, height},
           books,
           scene,
           dice.Tint(0.35));
      x += thickness;
    }
  }
}

void AddTable(const Eigen::Isometry3d& world_from_object,
              const Eigen::Vector3d& size,
              const SurfaceTexture& wood,
              const SurfaceTexture& things,
              int num_things,
              uint64_t seed,
              SimScene* scene) {
  constexpr double kTop = 0.035;
  Dice dice(seed);
  const double height = size.z();
  Legs(world_from_object, size.x() - 0.15, size.y() - 0.15, height - kTop, wood, scene);
  Part(world_from_object, {0, 0, height - kTop}, {size.x(), size.y(), kTop}, wood, scene);
  for (int i = 0; i < num_things; ++i) {
    const Eigen::Vector3d at(dice(-0.42, 0.42) * size.x(), dice(-0.38, 0.38) * size.y(), height);
    const Rgb tint = dice.Tint(0.4);
    const double kind = dice(0, 1);
    SurfaceStyle style = things.style;
    style.tint *= tint;
    SimMesh* mesh = MeshOf(things.index, false, scene);
    const double radius = dice(0.03, 0.06);
    if (kind < 0.55) {
      Part(world_from_object,
           at,
           {dice(0.08, 0.3), dice(0.06, 0.22), dice(0.03, 0.22)},
           things,
           scene,
           tint,
           dice(-40, 40));
    } else if (kind < 0.85) {
      AddCylinder(world_from_object * Placement(at, dice(0, 360)),
                  radius,
                  radius * 0.9,
                  dice(0.08, 0.2),
                  style,
                  mesh);
    } else {
      const Eigen::Vector3d up(0, 0, radius);
      AddSphere(world_from_object * Placement(at + up, dice(0, 360)), radius, style, mesh);
    }
  }
}

void AddChair(const Eigen::Isometry3d& world_from_object,
              const SurfaceTexture& wood,
              const SurfaceTexture& seat,
              SimScene* scene) {
  Legs(world_from_object, 0.38, 0.38, 0.44, wood, scene);
  Part(world_from_object, {0, 0, 0.44}, {0.44, 0.44, 0.05}, seat, scene);
  for (const double x : {-0.19, 0.19}) {
    Part(world_from_object, {x, 0.2, 0.49}, {0.04, 0.04, 0.45}, wood, scene);
  }
  for (const double z : {0.6, 0.72, 0.84}) {
    Part(world_from_object, {0, 0.2, z}, {0.34, 0.02, 0.07}, wood, scene);
  }
}

void AddSofa(const Eigen::Isometry3d& world_from_object,
             const Eigen::Vector3d& size,
             const SurfaceTexture& fabric,
             const SurfaceTexture& cushions,
             uint64_t seed,
             SimScene* scene) {
  Dice dice(seed);
  const double w = size.x();
  const double d = size.y();
  const double h = size.z();
  Part(world_from_object, {0, 0, 0.06}, {w, d, 0.4 * h}, fabric, scene);
  Part(world_from_object, {0, 0.5 * d - 0.1, 0.4 * h}, {w, 0.2, 0.6 * h}, fabric, scene);
  for (const double side : {-0.5, 0.5}) {
    Part(world_from_object, {side * (w - 0.18), 0, 0.4 * h}, {0.18, d, 0.3 * h}, fabric, scene);
  }
  const int num_cushions = std::max(2, static_cast<int>(w / 0.55));
  for (int i = 0; i < num_cushions; ++i) {
    const double x = (i + 0.5) / num_cushions * (w - 0.5) - 0.5 * (w - 0.5);
    Part(world_from_object,
         {x, 0.5 * d - 0.32, 0.4 * h + 0.06},
         {dice(0.36, 0.46), 0.14, dice(0.34, 0.42)},
         cushions,
         scene,
         dice.Tint(0.5),
         dice(-12, 12));
  }
}

void AddPlant(const Eigen::Isometry3d& world_from_object,
              double height,
              const SurfaceTexture& pot,
              const SurfaceTexture& leaves,
              uint64_t seed,
              SimScene* scene) {
  Dice dice(seed);
  const double pot_height = 0.3 * height;
  SimMesh* pot_mesh = MeshOf(pot.index, false, scene);
  AddCylinder(world_from_object, 0.13 * height, 0.18 * height, pot_height, pot.style, pot_mesh);
  SimMesh* leaf_mesh = MeshOf(leaves.index, true, scene);
  for (int i = 0; i < 28; ++i) {
    const double azimuth = dice(0, 2 * M_PI);
    const double reach = dice(0.12, 0.32) * height;
    const double rise = dice(0.2, 0.62) * height;
    const Eigen::Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
    const Eigen::Vector3d across(-std::sin(azimuth), std::cos(azimuth), 0);
    const double half_width = dice(0.02, 0.05) * height;
    const Eigen::Vector3d foot = Eigen::Vector3d(0, 0, pot_height) + 0.02 * out;
    SurfaceStyle style = leaves.style;
    style.tint *= dice.Tint(0.7);
    AddQuad(world_from_object * (foot - half_width * across),
            world_from_object.linear() * (2 * half_width * across),
            world_from_object.linear() * (reach * out + rise * Eigen::Vector3d::UnitZ()),
            style,
            leaf_mesh);
  }
}

void AddFacade(const Eigen::Isometry3d& world_from_object,
               const Eigen::Vector3d& size,
               int columns,
               int floors,
               const SurfaceTexture& wall,
               const SurfaceTexture& frame,
               const SurfaceTexture& glass,
               SimScene* scene) {
  constexpr double kRecess = 0.15;
  const double pitch = size.x() / columns;
  const double storey = size.z() / floors;
  const double window_w = 0.5 * pitch;
  const double window_h = 0.55 * storey;
  const double sill = 0.25 * storey;
  const double front = -0.5 * size.y();
  for (int floor = 0; floor < floors; ++floor) {
    const double z = floor * storey;
    // Wall below and above the windows, piers between them.
    Part(world_from_object, {0, 0, z}, {size.x(), size.y(), sill}, wall, scene);
    Part(world_from_object,
         {0, 0, z + sill + window_h},
         {size.x(), size.y(), storey - sill - window_h},
         wall,
         scene);
    for (int column = 0; column <= columns; ++column) {
      const bool edge = column == 0 || column == columns;
      const double width = edge ? 0.5 * (pitch - window_w) : pitch - window_w;
      const double x =
          column * pitch - 0.5 * size.x() + (column == 0 ? 0.5 : (edge ? -0.5 : 0.0)) * width;
      Part(world_from_object, {x, 0, z + sill}, {width, size.y(), window_h}, wall, scene);
      if (column == columns) break;
      const double middle = (column + 0.5) * pitch - 0.5 * size.x();
      const Rgb curtain =
          Rgb::Constant(0.25f + 0.08f * static_cast<float>((5 * column + 3 * floor) % 7));
      Part(world_from_object,
           {middle, front + kRecess + 0.05, z + sill},
           {window_w, 0.02, window_h},
           glass,
           scene,
           curtain);
      for (const double bar : {-0.47, 0.0, 0.47}) {
        Part(world_from_object,
             {middle + bar * window_w, front + kRecess, z + sill},
             {0.06, 0.06, window_h},
             frame,
             scene);
      }
      Part(world_from_object,
           {middle, front - 0.05, z + sill - 0.08},
           {window_w + 0.2, 0.25, 0.08},
           frame,
           scene);
    }
  }
}

}  // namespace prism
