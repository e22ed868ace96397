// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/optimize.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prism/factors/default_terms.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

SyntheticOptions SmallWindow() {
  SyntheticOptions options;
  options.num_keyframes = 4;
  options.num_points = 300;
  options.width = 320;
  options.height = 240;
  options.baseline = 0.04;
  return options;
}

// Largest error of the poses relative to the oldest keyframe's, metres and radians.
double LargestPoseError(const Window& window, const Window& truth) {
  double largest = 0;
  const auto relative = [](const Window& w, size_t i) {
    return w.keyframes[i]->state.pose() * w.keyframes[0]->state.pose().Inverse();
  };
  for (size_t i = 1; i < window.keyframes.size(); ++i) {
    const SE3 error = relative(window, i) * relative(truth, i).Inverse();
    largest = std::max(largest, error.Log().norm());
  }
  return largest;
}

TEST(OptimizeWindow, ReturnsToTheTruthFromPerturbedPosesAndDepths) {
  SyntheticOptions options = SmallWindow();
  options.w_sigma = 0.0005;
  const Window truth = MakeSyntheticWindow(options);
  Window window = MakeSyntheticWindow(options);
  PerturbWindow(0.003, 0.001, 0.03, &window);
  EXPECT_GT(LargestPoseError(window, truth), 2e-3);
  WindowOptions window_options;
  window_options.solve.max_iterations = 30;
  window_options.solve.function_tolerance = 1e-8;
  const OptimizationResult result = OptimizeWindow(window_options, MakeDefaultTerms({}), &window);
  EXPECT_TRUE(result.solve.usable);
  EXPECT_LT(result.solve.final_cost, 0.05 * result.solve.initial_cost);
  // A tenth of a pixel: bilinear interpolation dampens the finest waves of the texture.
  EXPECT_LT(LargestPoseError(window, truth), 1e-3);
}

TEST(OptimizeWindow, DepthResidualsHoldTheScaleThatPhotometryCannotSee) {
  // All depths and translations 10 % too large (about the front focal point): photometry is
  // content.
  for (const bool depth_residual : {true, false}) {
    SyntheticOptions options = SmallWindow();
    options.w_sigma = 0.001;
    Window window = MakeSyntheticWindow(options);
    const Eigen::Vector3d c(0, 0, window.camera.f);
    for (const auto& keyframe : window.keyframes) {
      const SE3 pose = keyframe->state.pose();
      keyframe->state.set_pose(SE3(pose.rotation(), c + 1.1 * (pose.translation() - c)));
      for (const auto& point : keyframe->points) {
        point->rho = 1 / (c.z() + 1.1 * (1 / point->rho - c.z()));
      }
    }
    WindowOptions window_options;
    DefaultTermOptions term_options;
    term_options.depth_residual = depth_residual;
    window_options.solve.max_iterations = 30;
    window_options.solve.function_tolerance = 1e-8;
    const SE3 first = window.keyframes.front()->state.pose();
    const SE3 last = window.keyframes.back()->state.pose();
    const double length_before = (last * first.Inverse()).translation().norm();
    OptimizeWindow(window_options, MakeDefaultTerms(term_options), &window);
    const double length =
        (window.keyframes.back()->state.pose() * window.keyframes.front()->state.pose().Inverse())
            .translation()
            .norm();
    EXPECT_NEAR(length / length_before, depth_residual ? 1 / 1.1 : 1.0, 0.02);
  }
}

TEST(OptimizeWindow, VarianceFactorsTellARightWeightFromAWrongOne) {
  SyntheticOptions options = SmallWindow();
  options.image_noise = 2;
  options.w_sigma = 0.004;
  Window window = MakeSyntheticWindow(options);
  WindowOptions window_options;
  // Two images with this noise, one of them interpolated.
  window.noise = NoiseModel(0, 2.5);
  const OptimizationResult result = OptimizeWindow(window_options, MakeDefaultTerms({}), &window);
  EXPECT_NEAR(result.VarianceFactor("photometric"), 1, 0.5);
  EXPECT_NEAR(result.VarianceFactor("inverse virtual depth"), 0.85, 0.25);
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) point->w_sigma = 0.001;
  }
  DefaultTermOptions term_options;
  term_options.robust_loss = false;
  EXPECT_GT(OptimizeWindow(window_options, MakeDefaultTerms(term_options), &window)
                .VarianceFactor("inverse virtual depth"),
            3);
}

TEST(OptimizeWindow, AffineBrightnessExplainsExposureAndCanBeHeld) {
  SyntheticOptions options = SmallWindow();
  Window window = MakeSyntheticWindow(options);
  auto brighter = std::make_shared<LightFieldFrame>(*window.keyframes[2]->frame);
  for (size_t i = 0; i < brighter->image[0].size(); ++i) brighter->image[0].data()[i] *= 1.1f;
  window.keyframes[2]->frame = brighter;
  // Points hosted there have patches of the old brightness.
  window.keyframes[2]->points.clear();
  Window held = MakeSyntheticWindow(options);
  held.keyframes[2]->frame = brighter;
  held.keyframes[2]->points.clear();
  WindowOptions window_options;
  window_options.solve.max_iterations = 30;
  window_options.solve.function_tolerance = 1e-8;
  const OptimizationResult free = OptimizeWindow(window_options, MakeDefaultTerms({}), &window);
  EXPECT_NEAR(window.keyframes[2]->state.a(), std::log(1.1), 0.03);
  window_options.graph.affine_brightness = false;
  const OptimizationResult fixed = OptimizeWindow(window_options, MakeDefaultTerms({}), &held);
  EXPECT_EQ(held.keyframes[2]->state.a(), 0);
  EXPECT_GT(fixed.solve.final_cost, 3 * free.solve.final_cost);
}

}  // namespace
}  // namespace prism
