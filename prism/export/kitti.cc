// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/kitti.h"

#include "prism/base/format.h"
#include "prism/io/atomic_file.h"
#include "prism/io/focused_sequence.h"

namespace prism {

std::string WriteKitti(const std::string& folder, const ExportRun& run) {
  std::string poses, times;
  for (const StampedPose& pose : run.trajectory) {
    const Eigen::Matrix3d R = pose.world_from_cam.RotationMatrix();
    const Eigen::Vector3d t = pose.world_from_cam.translation();
    for (int i = 0; i < 3; ++i) {
      poses += Format("%.9g %.9g %.9g %.9g", R(i, 0), R(i, 1), R(i, 2), t(i));
      poses += i < 2 ? ' ' : '\n';
    }
    times += FormatTime(pose.time_ns) + "\n";
  }
  WriteTextAtomically(InFolder(folder, "trajectory_kitti.txt"), poses);
  WriteTextAtomically(InFolder(folder, "trajectory_kitti_times.txt"), times);
  return Format("%zu poses", run.trajectory.size());
}

}  // namespace prism
