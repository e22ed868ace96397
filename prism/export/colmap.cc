// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/colmap.h"

#include <string>
#include <vector>

#include "prism/base/format.h"
#include "prism/export/tracks.h"
#include "prism/export/triangulation.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

std::string CameraText(const PlenopticProjection& camera) {
  return "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n" +
         Format("1 PINHOLE %d %d %.9g %.9g %.9g %.9g\n",
                camera.width,
                camera.height,
                camera.FocalLengthPx(),
                camera.FocalLengthPx(),
                camera.c.x() + 0.5,
                camera.c.y() + 0.5);
}

}  // namespace

std::string WriteColmap(const std::string& folder, const ExportRun& run) {
  const std::string root = InFolder(folder, "colmap");
  const std::string image_folder = InFolder(root, "images");
  CreateDirectory(image_folder);
  std::vector<Track> tracks = FindTracks(run);

  // Numbers of COLMAP begin at 1, those of an image's observations at 0.
  std::vector<std::string> observations(run.keyframes.size());
  std::vector<int> observation_count(run.keyframes.size(), 0);
  std::string points =
      "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  std::vector<SE3> cam_from_world;
  for (const ExportKeyframe& keyframe : run.keyframes) {
    cam_from_world.push_back(keyframe.world_from_cam.Inverse());
  }
  int point_count = 0, number = 0;
  double error_sum = 0, error_before = 0;
  size_t measured = 0, matches = 0;
  for (size_t i = 0; i < run.points.size(); ++i) {
    Track& track = tracks[i];
    if (track.observations.size() < 2) continue;
    const ExportPoint& point = run.points[i];
    const size_t matched = track.observations.size() - 1;
    const TriangulatedPoint triangulated =
        TriangulateWithoutOutliers(run.camera, cam_from_world, point.p_in_world, &track);
    if (track.observations.size() < 2) continue;
    ++point_count;
    points += Format("%d %.9g %.9g %.9g %d %d %d %.4f",
                     point_count,
                     triangulated.p_in_world.x(),
                     triangulated.p_in_world.y(),
                     triangulated.p_in_world.z(),
                     point.rgb[0],
                     point.rgb[1],
                     point.rgb[2],
                     triangulated.mean_error);
    for (const Observation& seen : track.observations) {
      points += Format(" %d %d", seen.keyframe + 1, observation_count[seen.keyframe]++);
      observations[seen.keyframe] +=
          Format("%.3f %.3f %d ", seen.px.x() + 0.5, seen.px.y() + 0.5, point_count);
    }
    points += '\n';
    const size_t count = track.observations.size();
    error_sum += triangulated.mean_error * static_cast<double>(count);
    measured += count;
    error_before += track.mean_error * static_cast<double>(matched);
    matches += matched;
  }

  std::string images =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, "
      "POINT3D_ID)\n";
  for (const ExportKeyframe& keyframe : run.keyframes) {
    const SE3 pose = WorldFromPinhole(run.camera, keyframe.world_from_cam).Inverse();
    const Eigen::Quaterniond q = pose.rotation();
    const Eigen::Vector3d t = pose.translation();
    const std::string name = keyframe.ImageName();
    images += Format("%d %.12g %.12g %.12g %.12g %.9g %.9g %.9g 1 ",
                     number + 1,
                     q.w(),
                     q.x(),
                     q.y(),
                     q.z(),
                     t.x(),
                     t.y(),
                     t.z()) +
              name + "\n" + observations[number] + "\n";
    ++number;
    WriteTextAtomically(InFolder(image_folder, name),
                        std::string(keyframe.image.begin(), keyframe.image.end()));
  }
  WriteTextAtomically(InFolder(root, "cameras.txt"), CameraText(run.camera));
  WriteTextAtomically(InFolder(root, "images.txt"), images);
  WriteTextAtomically(InFolder(root, "points3D.txt"), points);
  if (measured == 0) return Format("%d images, no points that two of them show", number);
  return Format(
      "%d images, %d points, %zu observations, mean reprojection error %.2f px (points of "
      "the map before they were triangulated: %.2f px)",
      number,
      point_count,
      measured,
      error_sum / static_cast<double>(measured),
      error_before / static_cast<double>(matches));
}

}  // namespace prism
