// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/window.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>

namespace prism {

bool WindowOptions::IsValid(std::string* error) const {
  if (max_keyframes < 3) {
    *error = "a window of " + std::to_string(max_keyframes) + " keyframes, expected 3 or more";
  } else if (max_points < 50) {
    *error = std::to_string(max_points) + " active points, expected 50 or more";
  } else if (max_iterations < 1 || threads < 1) {
    *error = "no iterations or threads, expected 1 or more";
  } else if (!(photometric.intensity_sigma > 0 && photometric_huber > 0 && depth_huber > 0 &&
               depth_outlier > 0)) {
    *error = "a standard deviation or robust threshold that is not positive";
  } else {
    return true;
  }
  return false;
}

int Window::NumPoints() const {
  int count = 0;
  for (const auto& keyframe : keyframes) count += static_cast<int>(keyframe->points.size());
  return count;
}

bool IsObserved(const PlenopticProjection& camera,
                const SE3& target_from_host,
                const Point& point,
                const Keyframe& target) {
  if (std::find(point.outlier_targets.begin(), point.outlier_targets.end(), target.id) !=
      point.outlier_targets.end()) {
    return false;
  }
  Eigen::Vector3d x_V;
  return ProjectBetweenFrames(camera, point.patch.px, point.rho, target_from_host, &x_V) &&
         target.frame->image[0].view().Contains(x_V.x(), x_V.y(), kPatternRadius + 2);
}

bool IsObserved(const Window& window,
                const Keyframe& host,
                const Point& point,
                const Keyframe& target) {
  return IsObserved(
      window.camera, target.state.pose() * host.state.pose().Inverse(), point, target);
}

double DepthAgreement(const Window& window,
                      const LightFieldFrame& frame,
                      const SE3& cam_from_world) {
  constexpr int kMinMeasured = 30;
  constexpr double kMinSigma = 0.004;
  int measured = 0, agreeing = 0;
  for (const auto& host : window.keyframes) {
    const SE3 cam_from_host = cam_from_world * host->state.pose().Inverse();
    for (const auto& point : host->points) {
      Eigen::Vector3d x_V;
      if (!ProjectBetweenFrames(window.camera, point->patch.px, point->rho, cam_from_host, &x_V) ||
          !frame.sigma.view().Contains(x_V.x(), x_V.y(), 1)) {
        continue;
      }
      const int x = static_cast<int>(x_V.x() + 0.5);
      const int y = static_cast<int>(x_V.y() + 0.5);
      const double sigma = frame.sigma(x, y);
      if (sigma == 0) continue;
      ++measured;
      agreeing += std::abs(frame.inverse_virtual_depth(x, y) - 1 / x_V.z()) <
                  3 * std::max(sigma, kMinSigma);
    }
  }
  return measured < kMinMeasured ? 0 : static_cast<double>(agreeing) / measured;
}

void AnchorFirstKeyframe(Window* window) {
  CHECK_EQ(window->keyframes.size(), 1u);
  // 0.1 mm, 0.1 mrad, 0.1 % of gain and 0.1 intensities: far below what images tell.
  Eigen::Matrix<double, FrameState::kTangentSize, 1> information;
  information << 1e4, 1e4, 1e4, 1e4, 1e4, 1e4, 1e3, 10;
  window->prior.A = information.asDiagonal();
  window->prior.b = Eigen::VectorXd::Zero(FrameState::kTangentSize);
  window->prior.linearization = {window->newest().state};
  window->prior_keyframe_ids = {window->newest().id};
  window->newest().first_estimate = window->newest().state;
}

}  // namespace prism
