// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/ply.h"

#include <cstring>
#include <map>

#include "prism/base/format.h"
#include "prism/io/atomic_file.h"

namespace prism {

std::vector<OrientedPoint> SparsePoints(const ExportRun& run) {
  std::map<int, Eigen::Vector3d> center_of_id;
  for (const ExportKeyframe& keyframe : run.keyframes) {
    center_of_id[keyframe.id] = WorldFromPinhole(run.camera, keyframe.world_from_cam).translation();
  }
  std::vector<OrientedPoint> points;
  for (const ExportPoint& point : run.points) {
    const Eigen::Vector3d ray = center_of_id.at(point.keyframe_id) - point.p_in_world;
    points.push_back({point.p_in_world.cast<float>(),
                      ray.normalized().cast<float>(),
                      point.rgb,
                      static_cast<float>(point.sigma_m)});
  }
  return points;
}

void WriteOrientedPly(const std::string& path, const std::vector<OrientedPoint>& points) {
  std::string contents =
      "ply\nformat binary_little_endian 1.0\ncomment PRISM-VO, metres\nelement vertex " +
      std::to_string(points.size()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    contents += std::string("property float ") + name + "\n";
  }
  for (const char* name : {"red", "green", "blue"}) {
    contents += std::string("property uchar ") + name + "\n";
  }
  contents += "property float sigma\nend_header\n";
  constexpr size_t kBytesPerPoint = 7 * sizeof(float) + 3;
  contents.reserve(contents.size() + kBytesPerPoint * points.size());
  for (const OrientedPoint& point : points) {
    char bytes[kBytesPerPoint];
    std::memcpy(bytes, point.position.data(), 12);
    std::memcpy(bytes + 12, point.view_direction.data(), 12);
    std::memcpy(bytes + 24, point.rgb.data(), 3);
    std::memcpy(bytes + 27, &point.sigma_m, 4);
    contents.append(bytes, kBytesPerPoint);
  }
  WriteTextAtomically(path, contents);
}

std::string WriteSparsePly(const std::string& folder, const ExportRun& run) {
  WriteOrientedPly(InFolder(folder, "points_oriented.ply"), SparsePoints(run));
  return Format("%zu points", run.points.size());
}

}  // namespace prism
