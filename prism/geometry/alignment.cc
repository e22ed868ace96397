// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/geometry/alignment.h"

#include <cmath>

#include <glog/logging.h>
#include <Eigen/Geometry>

namespace prism {

AlignmentResult AlignPoints(const std::vector<Eigen::Vector3d>& source,
                            const std::vector<Eigen::Vector3d>& target,
                            bool with_scale) {
  CHECK_EQ(source.size(), target.size());
  AlignmentResult result;
  if (source.size() < 3) return result;

  using PointMap = Eigen::Map<const Eigen::Matrix3Xd>;
  const auto count = static_cast<Eigen::Index>(source.size());
  const PointMap source_points(source[0].data(), 3, count);
  const PointMap target_points(target[0].data(), 3, count);
  const Eigen::Matrix4d transform = Eigen::umeyama(source_points, target_points, with_scale);

  const Eigen::Matrix3d scaled_rotation = transform.topLeftCorner<3, 3>();
  Sim3& sim3 = result.target_from_source;
  sim3.scale = with_scale ? std::cbrt(scaled_rotation.determinant()) : 1.0;
  sim3.rigid = SE3(Eigen::Quaterniond(Eigen::Matrix3d(scaled_rotation / sim3.scale)),
                   transform.topRightCorner<3, 1>());
  double sum = 0;
  for (size_t i = 0; i < source.size(); ++i) sum += (target[i] - sim3 * source[i]).squaredNorm();
  result.rmse = std::sqrt(sum / static_cast<double>(count));
  result.success = std::isfinite(result.rmse) && sim3.scale > 0;
  return result;
}

}  // namespace prism
