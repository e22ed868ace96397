// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/visibility.h"

#include <algorithm>
#include <vector>

namespace prism {

namespace {

bool Holds(const std::vector<int>& ids, int id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

}  // namespace

bool IsHidden(const Point& point, const Keyframe& target) {
  return Holds(point.outlier_targets, target.id);
}

bool IsDepthOutlier(const Point& point, const Keyframe& target) {
  return Holds(point.depth_outlier_targets, target.id);
}

bool IsObserved(const PlenopticProjection& camera,
                const RigidMotion& target_from_host,
                const Point& point,
                const Keyframe& target,
                Eigen::Vector3d* x_V) {
  return !IsHidden(point, target) &&
         ProjectBetweenFrames(camera, point.patch.px, point.rho, target_from_host, x_V) &&
         target.frame->image[0].view().Contains(x_V->x(), x_V->y(), kPatternRadius + 2);
}

bool IsObserved(const PlenopticProjection& camera,
                const RigidMotion& target_from_host,
                const Point& point,
                const Keyframe& target) {
  Eigen::Vector3d x_V;
  return IsObserved(camera, target_from_host, point, target, &x_V);
}

bool IsObserved(const Window& window,
                const Keyframe& host,
                const Point& point,
                const Keyframe& target) {
  return IsObserved(
      window.camera, target.state.pose() * host.state.pose().Inverse(), point, target);
}

}  // namespace prism
