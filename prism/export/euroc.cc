// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/euroc.h"

#include "prism/base/format.h"
#include "prism/io/atomic_file.h"

namespace prism {

std::string WriteEuroc(const std::string& folder, const ExportRun& run) {
  std::string text = "#timestamp [ns],px [m],py [m],pz [m],qw,qx,qy,qz\n";
  for (const StampedPose& pose : run.trajectory) {
    const Eigen::Vector3d t = pose.world_from_cam.translation();
    const Eigen::Quaterniond q = pose.world_from_cam.rotation();
    text += Format("%lld,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                   static_cast<long long>(pose.time_ns),
                   t.x(),
                   t.y(),
                   t.z(),
                   q.w(),
                   q.x(),
                   q.y(),
                   q.z());
  }
  WriteTextAtomically(InFolder(folder, "trajectory_euroc.csv"), text);
  return Format("%zu poses", run.trajectory.size());
}

}  // namespace prism
