// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// Offsets of measured depths as states, and whether the uncertainty of the scale holds.
#include <gtest/gtest.h>

#include "prism/factors/default_terms.h"
#include "prism/factors/prior_term.h"
#include "prism/window/optimize.h"
#include "prism/window/retirement.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

WindowOptions Thorough() {
  WindowOptions options;
  options.solve.max_iterations = 50;
  options.solve.function_tolerance = 1e-10;
  options.solve.threads = 1;
  return options;
}

DefaultTermOptions WithOffsets(double prior_sigma) {
  DefaultTermOptions options;
  options.depth_offset.prior_sigma = prior_sigma;
  return options;
}

// A window whose keyframes came one by one, the first of them anchored; all measured 1/v are
// shifted by `offset`.
Window MakeShiftedWindow(double offset, unsigned seed, const TermList& terms) {
  SyntheticOptions options;
  options.num_keyframes = 5;
  options.num_points = 600;
  options.width = 320;
  options.height = 240;
  options.baseline = 0.08;
  options.image_noise = 2;
  options.w_sigma = 0.002;
  options.seed = seed;
  Window window = MakeSyntheticWindow(options);
  window.noise = NoiseModel(options.image_noise, 0);
  ReplayKeyframes(&window, [&](Window* w) {
    for (const auto& point : w->newest().points) point->w_measured += offset;
    if (w->keyframes.size() == 1) AnchorFirstKeyframe(w);
    for (const auto& term : terms) term->AddStates(w);
  });
  return window;
}

double PathLength(const Window& window) {
  double path = 0;
  for (size_t i = 1; i < window.keyframes.size(); ++i) {
    path += (window.keyframes[i]->state.pose().Inverse().translation() -
             window.keyframes[i - 1]->state.pose().Inverse().translation())
                .norm();
  }
  return path;
}

TEST(DepthOffset, StatedUncertaintyHolds) {
  const TermList terms = MakeDefaultTerms(WithOffsets(0.003));
  constexpr int kRuns = 12;
  double scale_square = 0, offset_square = 0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    // Drawn from the prior.
    std::mt19937_64 generator = SeededGenerator(seed, 7);
    const double offset = std::normal_distribution<double>(0, 0.003)(generator);
    Window window = MakeShiftedWindow(offset, seed, terms);
    const double truth = PathLength(window);
    const OptimizationResult result = OptimizeWindow(Thorough(), terms, &window);
    ASSERT_TRUE(result.uncertainty.has_value());
    const WindowUncertainty& known = *result.uncertainty;
    EXPECT_NEAR(known.path_m, PathLength(window), 1e-12);
    scale_square += std::pow(std::log(known.path_m / truth) / known.scale_sigma, 2);
    offset_square += std::pow((known.depth_offset - offset) / known.depth_offset_sigma, 2);
    EXPECT_LT(known.depth_offset_sigma, 0.003);
  }
  // Of 12 normalised errors the RMS is within 0.6 to 1.4 in 95 of 100 cases.
  EXPECT_GT(std::sqrt(scale_square / kRuns), 0.5);
  EXPECT_LT(std::sqrt(scale_square / kRuns), 1.5);
  EXPECT_GT(std::sqrt(offset_square / kRuns), 0.5);
  EXPECT_LT(std::sqrt(offset_square / kRuns), 1.5);
}

TEST(DepthOffset, WithoutItTheStatedUncertaintyOfAShiftedSensorDoesNotHold) {
  DefaultTermOptions options;
  options.depth_offset.per_keyframe = false;
  const TermList terms = MakeDefaultTerms(options);
  Window window = MakeShiftedWindow(0.003, 0, terms);
  const double truth = PathLength(window);
  const OptimizationResult result = OptimizeWindow(Thorough(), terms, &window);
  ASSERT_TRUE(result.uncertainty.has_value());
  EXPECT_EQ(result.uncertainty->depth_offset, 0);
  EXPECT_GT(std::abs(std::log(result.uncertainty->path_m / truth)),
            5 * result.uncertainty->scale_sigma);
}

TEST(DepthOffset, AShiftThatIsNoStateIsInTheStatedScale) {
  const TermList terms = MakeDefaultTerms(DefaultTermOptions());
  const auto known = [](double offset, const TermList& terms_of_window) {
    Window window = MakeShiftedWindow(offset, 2, terms_of_window);
    return OptimizeWindow(Thorough(), terms_of_window, &window).uncertainty.value();
  };
  const WindowUncertainty as_measured = known(0, terms);
  // All but that shift: it is a state, but known.
  DefaultTermOptions no_shift = WithOffsets(1e-9);
  no_shift.depth_offset.step_sigma = 1e-9;
  const double without = known(0, MakeDefaultTerms(no_shift)).scale_sigma;
  const double shift = NoiseModel().DepthOffsetSigma();
  const double change = std::log(known(shift, terms).path_m / as_measured.path_m);
  EXPECT_GT(std::abs(change), 0.3 * without);
  EXPECT_NEAR(as_measured.scale_sigma, std::hypot(without, change), 0.1 * std::abs(change));
}

TEST(DepthOffset, WhatIsKnownOfItStaysWhenKeyframesLeave) {
  const TermList terms = MakeDefaultTerms(WithOffsets(0.003));
  Window window = MakeShiftedWindow(0.003, 1, terms);
  const OptimizationResult before = OptimizeWindow(Thorough(), terms, &window);
  RetireKeyframe(Thorough(), terms, 0, &window);
  RetireKeyframe(Thorough(), terms, 2, &window);
  const OptimizationResult after = OptimizeWindow(Thorough(), terms, &window);
  ASSERT_TRUE(before.uncertainty && after.uncertainty);
  EXPECT_NEAR(after.uncertainty->depth_offset,
              before.uncertainty->depth_offset,
              0.5 * before.uncertainty->depth_offset_sigma);
  EXPECT_LT(after.uncertainty->depth_offset_sigma, 1.3 * before.uncertainty->depth_offset_sigma);
}

TEST(DepthOffset, StaysAtItsPriorWhereDepthsSayNothing) {
  const TermList terms = MakeDefaultTerms(WithOffsets(0.0003));
  Window window = MakeShiftedWindow(0, 2, terms);
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) point->w_sigma = 10;
  }
  const OptimizationResult result = OptimizeWindow(Thorough(), terms, &window);
  ASSERT_TRUE(result.uncertainty.has_value());
  EXPECT_NEAR(result.uncertainty->depth_offset, 0, 1e-6);
  // The prior, and four steps of the walk.
  EXPECT_NEAR(result.uncertainty->depth_offset_sigma, std::hypot(0.0003, 2 * 0.0001), 1e-5);
}

}  // namespace
}  // namespace prism
