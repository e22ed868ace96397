// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/error_dependence.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

constexpr int kFrames = 24;
constexpr int kPerFrame = 400;
constexpr double kFrameSigma = 0.002;
constexpr double kPointSigma = 0.004;
constexpr double kSlope = 0.003;

// Errors with an offset of each frame, and a part that rises with one of two features.
struct PlantedErrors {
  std::vector<ErrorSample> samples;
  std::vector<double> cause, unrelated;
};

PlantedErrors MakeErrors() {
  PlantedErrors planted;
  std::mt19937_64 generator = SeededGenerator(3, 0);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int frame = 0; frame < kFrames; ++frame) {
    const double offset = kFrameSigma * gauss(generator);
    for (int i = 0; i < kPerFrame; ++i) {
      planted.cause.push_back(uniform(generator));
      planted.unrelated.push_back(uniform(generator));
      const double error = offset + kSlope * planted.cause.back() + kPointSigma * gauss(generator);
      planted.samples.push_back({frame, error, kPointSigma});
    }
  }
  return planted;
}

TEST(ErrorDependence, MedianMeanAndSigmaAreThoseOfTheInliers) {
  std::vector<ErrorSample> samples;
  for (int i = -50; i <= 50; ++i) samples.push_back({0, 0.001 + 0.0001 * i, 0.002});
  for (int i = 0; i < 5; ++i) samples.push_back({0, 0.5, 0.002});
  const ErrorSummary summary = SummarizeErrors(samples, 0.02);
  EXPECT_EQ(summary.count, 106);
  EXPECT_NEAR(summary.median, 0.001, 4e-4);
  EXPECT_NEAR(summary.trimmed_mean, 0.001, 5e-4);
  EXPECT_NEAR(summary.robust_sigma, 1.4826 * 0.0025, 3e-4);
  EXPECT_NEAR(summary.large_fraction, 5 / 106.0, 1e-12);
  EXPECT_NEAR(summary.rms, std::sqrt(5 * 0.25 / 106), 1e-3);
  EXPECT_NEAR(summary.normalized_sigma, 1.4826 * 0.0025 / 0.002, 0.3);
  EXPECT_EQ(SummarizeErrors({}, 0.02).count, 0);
}

TEST(ErrorDependence, APlantedDependenceIsFoundAndNoOther) {
  const PlantedErrors planted = MakeErrors();
  const ErrorBinOptions options;
  const std::vector<ErrorBin> bins = BinErrors(planted.samples, planted.cause, options);
  ASSERT_EQ(bins.size(), 6u);
  for (const ErrorBin& bin : bins) {
    EXPECT_EQ(bin.errors.count, kFrames * kPerFrame / 6);
    EXPECT_NEAR(bin.excess, kSlope * (bin.middle - 0.5), 4 * bin.excess_standard_error);
    EXPECT_NEAR(bin.errors.robust_sigma, std::hypot(kFrameSigma, kPointSigma), 7e-4);
  }
  EXPECT_LT(bins.front().excess, -6 * bins.front().excess_standard_error);
  EXPECT_GT(bins.back().excess, 6 * bins.back().excess_standard_error);
  for (const ErrorBin& bin : BinErrors(planted.samples, planted.unrelated, options)) {
    EXPECT_LT(std::abs(bin.excess), 4 * bin.excess_standard_error) << bin.middle;
  }
}

TEST(ErrorDependence, WhatAFrameHasInCommonIsInTheStandardErrorOfAMedianButNotOfAnExcess) {
  const PlantedErrors planted = MakeErrors();
  const double of_frames = kFrameSigma / std::sqrt(kFrames);
  for (const ErrorBin& bin : BinErrors(planted.samples, planted.unrelated, {})) {
    EXPECT_GT(bin.median_standard_error, 0.6 * of_frames);
    EXPECT_LT(bin.median_standard_error, 1.6 * of_frames);
    EXPECT_LT(bin.excess_standard_error, 0.5 * of_frames);
  }
}

TEST(ErrorDependence, ValuesWithoutTheFeatureComeLastAndEqualValuesShareABin) {
  std::vector<ErrorSample> samples;
  std::vector<double> feature;
  for (int i = 0; i < 100; ++i) {
    samples.push_back({i % 4, i < 90 ? 0.001 : 0.005, 0.004});
    feature.push_back(i < 80 ? 1 : i < 90 ? 2 : NAN);
  }
  const std::vector<ErrorBin> bins = BinErrors(samples, feature, {});
  ASSERT_EQ(bins.size(), 3u);
  EXPECT_EQ(bins[0].errors.count, 80);
  EXPECT_EQ(bins[1].middle, 2);
  EXPECT_TRUE(std::isnan(bins[2].middle));
  EXPECT_NEAR(bins[2].excess, 0.004, 1e-12);
  ErrorBinOptions discrete;
  discrete.is_discrete = true;
  EXPECT_EQ(BinErrors(samples, feature, discrete).size(), 3u);
  EXPECT_TRUE(BinErrors({}, {}, {}).empty());
}

TEST(ErrorDependence, OneFrameTellsNoStandardError) {
  const std::vector<ErrorSample> samples = {{7, 0.001, 0.004}, {7, 0.002, 0.004}};
  const std::vector<ErrorBin> bins = BinErrors(samples, {1, 2}, {});
  ASSERT_EQ(bins.size(), 2u);
  EXPECT_TRUE(std::isnan(bins[0].median_standard_error));
  EXPECT_TRUE(std::isnan(bins[0].excess_standard_error));
}

TEST(ErrorDependence, TheSpreadOverFramesIsThatOfWhatTheyHaveInCommon) {
  const PlantedErrors planted = MakeErrors();
  std::vector<ErrorSummary> frames(1);  // a frame without points counts for nothing
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto first = planted.samples.begin() + frame * kPerFrame;
    frames.push_back(SummarizeErrors({first, first + kPerFrame}, 0.02));
  }
  const FrameSpread spread = SpreadOverFrames(frames);
  EXPECT_EQ(spread.frames, kFrames);
  EXPECT_NEAR(spread.mean_of_medians, 0.5 * kSlope, 3 * kFrameSigma / std::sqrt(kFrames));
  EXPECT_NEAR(spread.median_sigma, kFrameSigma, 0.4 * kFrameSigma);
  EXPECT_NEAR(spread.mean_sigma, kFrameSigma, 0.4 * kFrameSigma);
  EXPECT_EQ(SpreadOverFrames({}).frames, 0);
}

}  // namespace
}  // namespace prism
