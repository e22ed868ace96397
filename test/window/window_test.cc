// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/window.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prism/window/activation.h"
#include "prism/window/candidates.h"
#include "prism/window/optimize.h"
#include "prism/window/outliers.h"
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
  window_options.max_iterations = 30;
  window_options.function_tolerance = 1e-8;
  const OptimizationResult result = OptimizeWindow(window_options, &window);
  EXPECT_TRUE(result.usable);
  EXPECT_LT(result.final_cost, 0.05 * result.initial_cost);
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
    window_options.depth_residual = depth_residual;
    window_options.max_iterations = 30;
    window_options.function_tolerance = 1e-8;
    const SE3 first = window.keyframes.front()->state.pose();
    const SE3 last = window.keyframes.back()->state.pose();
    const double length_before = (last * first.Inverse()).translation().norm();
    OptimizeWindow(window_options, &window);
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
  window_options.photometric.intensity_sigma = 2.5;
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) {
      MakePatch(
          keyframe->frame->image[0], point->patch.px, window_options.photometric, &point->patch);
    }
  }
  const OptimizationResult result = OptimizeWindow(window_options, &window);
  EXPECT_NEAR(result.variance_factors.photometric, 1, 0.5);
  EXPECT_NEAR(result.variance_factors.depth, 0.85, 0.25);
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) point->w_sigma = 0.001;
  }
  window_options.robust_loss = false;
  EXPECT_GT(OptimizeWindow(window_options, &window).variance_factors.depth, 3);
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
  window_options.max_iterations = 30;
  window_options.function_tolerance = 1e-8;
  const OptimizationResult free = OptimizeWindow(window_options, &window);
  EXPECT_NEAR(window.keyframes[2]->state.a(), std::log(1.1), 0.03);
  window_options.affine_brightness = false;
  const OptimizationResult fixed = OptimizeWindow(window_options, &held);
  EXPECT_EQ(held.keyframes[2]->state.a(), 0);
  EXPECT_GT(fixed.final_cost, 3 * free.final_cost);
}

TEST(RefineInverseDepth, FindsTheDepthOthersSee) {
  SyntheticOptions options = SmallWindow();
  const Window window = MakeSyntheticWindow(options);
  int found = 0, tried = 0;
  double squared_error = 0;
  for (const auto& truth : window.keyframes[0]->points) {
    Point point = *truth;
    point.rho *= 1.03;
    point.w_sigma = 0;
    const DepthRefinement refined = RefineInverseDepth(window, {}, 0, point, {});
    ++tried;
    if (!refined.success || refined.observations == 0) continue;
    ++found;
    squared_error += std::pow(refined.rho / truth->rho - 1, 2);
  }
  EXPECT_GT(found, tried * 3 / 4);
  EXPECT_LT(std::sqrt(squared_error / found), 0.01);
}

TEST(RefineInverseDepth, AMeasurementAloneIsEnough) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 1;
  const Window window = MakeSyntheticWindow(options);
  const Point& point = *window.keyframes[0]->points[0];
  const DepthRefinement refined = RefineInverseDepth(window, {}, 0, point, {});
  EXPECT_TRUE(refined.success);
  EXPECT_EQ(refined.observations, 0);
  EXPECT_NEAR(InverseVirtualDepth(window.camera, refined.rho), point.w_measured, 1e-6);
}

TEST(RemoveOutliers, DropsAPointThatMatchesNothingAndAWrongMeasurement) {
  Window window = MakeSyntheticWindow(SmallWindow());
  Point& wrong = *window.keyframes[0]->points[0];
  for (float& intensity : wrong.patch.intensity) intensity = 255 - intensity;
  const float marker = wrong.patch.intensity[0];
  window.keyframes[1]->points[0]->w_measured += 0.05;
  const size_t before = window.keyframes[0]->points.size();
  const OutlierResult result = RemoveOutliers({}, {}, &window);
  EXPECT_GE(result.points_dropped, 1);
  EXPECT_EQ(result.depth_measurements_dropped, 1);
  EXPECT_LT(window.keyframes[0]->points.size(), before);
  EXPECT_NE(window.keyframes[0]->points[0]->patch.intensity[0], marker);
  EXPECT_EQ(window.keyframes[1]->points[0]->w_sigma, 0);
}

TEST(CoverageMap, KnowsWherePointsAre) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 1;
  options.num_points = 1;
  const Window window = MakeSyntheticWindow(options);
  const Eigen::Vector2i px = window.keyframes[0]->points[0]->patch.px.cast<int>();
  const CoverageMap coverage(window);
  EXPECT_FALSE(coverage.IsFree(px.x() + 3, px.y() - 3, 3));
  EXPECT_TRUE(coverage.IsFree(px.x() + 4, px.y(), 3));
}

TEST(SearchEpipolarLine, FindsTheTrueDepthInAWideInterval) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 2;
  options.baseline = 0.1;
  const Window window = MakeSyntheticWindow(options);
  FramePair pair;
  pair.Update(window.keyframes[0]->state, window.keyframes[1]->state);
  int found = 0, wrong = 0;
  for (const auto& point : window.keyframes[0]->points) {
    const EpipolarSearchResult match = SearchEpipolarLine(window.camera,
                                                          point->patch,
                                                          pair,
                                                          window.keyframes[1]->frame->image[0],
                                                          0.6 * point->rho,
                                                          1.6 * point->rho,
                                                          {});
    if (match.status != EpipolarSearchStatus::kFound) continue;
    ++found;
    wrong += std::abs(match.rho / point->rho - 1) > 0.02;
  }
  EXPECT_GT(found, 50);
  EXPECT_LT(wrong, found / 10);
}

TEST(SearchEpipolarLine, SaysWhenTheParallaxIsTooSmall) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 2;
  options.baseline = 1e-4;
  const Window window = MakeSyntheticWindow(options);
  FramePair pair;
  pair.Update(window.keyframes[0]->state, window.keyframes[1]->state);
  const Point& point = *window.keyframes[0]->points[0];
  EXPECT_EQ(
      SearchEpipolarLine(
          window.camera, point.patch, pair, window.keyframes[1]->frame->image[0], 0.4, 0.6, {})
          .status,
      EpipolarSearchStatus::kTooShort);
}

TEST(Candidates, WithoutAMeasurementBecomePointsByMotionAlone) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 4;
  options.baseline = 0.05;
  Window window = MakeSyntheticWindow(options);
  Keyframe& host = *window.keyframes[0];
  CandidateOptions candidate_options;
  candidate_options.max_rho = 1.5;
  std::vector<std::unique_ptr<Point>> truth = std::move(host.points);
  host.points.clear();
  for (const auto& point : truth) {
    Candidate candidate;
    candidate.patch = point->patch;
    candidate.rho = 0.75;
    candidate.rho_variance = 0.3 * 0.3;
    host.candidates.push_back(candidate);
  }
  for (size_t i = 1; i < 4; ++i) {
    UpdateCandidates(candidate_options,
                     window.keyframes[i]->frame->image[0],
                     window.keyframes[i]->state,
                     &window);
  }
  CoverageMap coverage(window);
  const int activated = ActivateCandidates({}, candidate_options, {}, 1, 1000, &coverage, &window);
  EXPECT_GT(activated, 20);
  ASSERT_EQ(static_cast<size_t>(activated), host.points.size());
  int wrong = 0;
  for (const auto& point : host.points) {
    Eigen::Vector3d p;
    const double z = PlaneDepth(window.camera, host.state.pose(), point->patch.px, &p);
    wrong += std::abs(point->rho * z - 1) > 0.02;
    EXPECT_EQ(point->w_sigma, 0);
  }
  EXPECT_LT(wrong, activated / 10 + 1);
}

}  // namespace
}  // namespace prism
