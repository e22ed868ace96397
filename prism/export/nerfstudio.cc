// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/nerfstudio.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "prism/base/format.h"
#include "prism/export/ply.h"
#include "prism/io/atomic_file.h"
#include "prism/io/image_file.h"

namespace prism {
namespace {

cv::Mat DepthInMillimetres(const PlenopticProjection& camera, const DepthMap& map) {
  const ImageF& w = map.inverse_virtual_depth;
  cv::Mat depth(w.height(), w.width(), CV_16UC1, cv::Scalar(0));
  for (int y = 0; y < w.height(); ++y) {
    for (int x = 0; x < w.width(); ++x) {
      if (w(x, y) == 0) continue;
      const double rho = InverseDepth(camera, w(x, y));
      if (rho <= 0) continue;
      const double mm = std::round(1e3 * (1 / rho - camera.center_z()));
      if (mm >= 1 && mm <= 65535) depth.at<uint16_t>(y, x) = static_cast<uint16_t>(mm);
    }
  }
  return depth;
}

nlohmann::ordered_json OpenGlPose(const SE3& world_from_pinhole) {
  const Eigen::Matrix3d R =
      world_from_pinhole.RotationMatrix() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Vector3d t = world_from_pinhole.translation();
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({R(i, 0), R(i, 1), R(i, 2), t(i)});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

}  // namespace

std::string WriteNerfstudio(const std::string& folder, const ExportRun& run) {
  const std::string root = InFolder(folder, "nerfstudio");
  CreateDirectory(InFolder(root, "images"));
  CreateDirectory(InFolder(root, "depths"));
  nlohmann::ordered_json json = {{"camera_model", "OPENCV"},
                                 {"w", run.camera.width},
                                 {"h", run.camera.height},
                                 {"fl_x", run.camera.FocalLengthPx()},
                                 {"fl_y", run.camera.FocalLengthPx()},
                                 // Pixel coordinates from the corner of the first pixel.
                                 {"cx", run.camera.c.x() + 0.5},
                                 {"cy", run.camera.c.y() + 0.5},
                                 {"k1", 0},
                                 {"k2", 0},
                                 {"p1", 0},
                                 {"p2", 0},
                                 {"ply_file_path", "points.ply"}};
  json["frames"] = nlohmann::ordered_json::array();
  for (const ExportKeyframe& keyframe : run.keyframes) {
    const std::string image = "images/" + keyframe.ImageName();
    const std::string depth = "depths/" + keyframe.ImageName();
    WriteTextAtomically(InFolder(root, image),
                        std::string(keyframe.image.begin(), keyframe.image.end()));
    WriteImage(InFolder(root, depth), DepthInMillimetres(run.camera, DecodeDepth(keyframe)));
    json["frames"].push_back(
        {{"file_path", image},
         {"depth_file_path", depth},
         {"transform_matrix", OpenGlPose(WorldFromPinhole(run.camera, keyframe.world_from_cam))},
         {"time", 1e-9 * static_cast<double>(keyframe.time_ns)}});
  }
  WriteOrientedPly(InFolder(root, "points.ply"), SparsePoints(run));
  WriteTextAtomically(InFolder(root, "transforms.json"), json.dump(1) + "\n");
  return Format("%zu images, %zu points", run.keyframes.size(), run.points.size());
}

}  // namespace prism
