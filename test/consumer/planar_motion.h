// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// A residual of one's own, all of it in one file: a camera on a cart, which can drive and turn but
// neither leave the ground nor tilt. docs/add_a_residual.md goes through it step by step.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <prism/factors/term.h>

struct PlanarMotionOptions {
  Eigen::Vector3d up = {0, -1, 0};  // of the ground, in the camera frame; not zero
  double tilt_sigma = 0.01;         // rad, of roll and of pitch: how even the ground is
  double height_sigma = 0.005;      // m
};

// What a keyframe has that the first one had not, in standard deviations:
//   r = [e1^T R u / sigma_tilt; e2^T R u / sigma_tilt; u^T c / sigma_height],
// with cam_from_world (R, t), the camera centre c = -R^T t, the unit vector u up, and e1, e2 that
// complete it to a basis. World is the camera frame of the first frame, so that R u = u and u^T c =
// 0 is a camera that has stayed level and at its height.
//
// Residuals: 3. Parameter block: FrameState (9: qx qy qz qw tx ty tz a b). Jacobian: automatic.
class PlanarMotionCost {
 public:
  explicit PlanarMotionCost(const PlanarMotionOptions& options)
      : up_(options.up.normalized()),
        e1_(up_.unitOrthogonal()),
        e2_(up_.cross(e1_)),
        tilt_sigma_(options.tilt_sigma),
        height_sigma_(options.height_sigma) {}

  template <typename T>
  bool operator()(const T* frame, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(frame);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t(frame + 4);
    const Eigen::Matrix<T, 3, 1> up_in_cam = q * up_.cast<T>();
    residuals[0] = e1_.cast<T>().dot(up_in_cam) / tilt_sigma_;
    residuals[1] = e2_.cast<T>().dot(up_in_cam) / tilt_sigma_;
    residuals[2] = -up_in_cam.dot(t) / height_sigma_;
    return true;
  }

 private:
  Eigen::Vector3d up_, e1_, e2_;
  double tilt_sigma_, height_sigma_;
};

// A PlanarMotionCost for every keyframe of the window.
class PlanarMotionTerm : public prism::Term {
 public:
  explicit PlanarMotionTerm(const PlanarMotionOptions& options) : options_(options) {}

  std::string name() const override { return "planar motion"; }

  void AddFactors(const prism::Window& window, prism::WindowGraph* graph) const override {
    for (size_t i = 0; i < window.keyframes.size(); ++i) {
      prism::FactorGraph::NewFactor factor;
      factor.cost = std::make_unique<ceres::AutoDiffCostFunction<PlanarMotionCost, 3, 9>>(
          new PlanarMotionCost(options_));
      graph->AddFactor(std::move(factor), {graph->FrameBlock(i)});
    }
  }

 private:
  PlanarMotionOptions options_;
};
