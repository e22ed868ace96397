// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "prism/factors/default_terms.h"
#include "prism/points/candidates.h"
#include "prism/points/coverage.h"
#include "prism/points/epipolar_search.h"
#include "prism/points/outliers.h"
#include "prism/points/refinement.h"
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

TEST(DepthRefiner, FindsTheDepthOthersSee) {
  SyntheticOptions options = SmallWindow();
  const Window window = MakeSyntheticWindow(options);
  const TermList terms = MakeDefaultTerms({});
  DepthRefiner refiner(window, terms, {});
  int found = 0, tried = 0;
  double squared_error = 0;
  for (const auto& truth : window.keyframes[0]->points) {
    Point point = *truth;
    point.rho *= 1.03;
    point.w_sigma = 0;
    const DepthRefinement refined = refiner.Refine(0, point);
    ++tried;
    if (!refined.success || refined.observations == 0) continue;
    ++found;
    squared_error += std::pow(refined.rho / truth->rho - 1, 2);
  }
  EXPECT_GT(found, tried * 3 / 4);
  EXPECT_LT(std::sqrt(squared_error / found), 0.01);
}

TEST(DepthRefiner, AMeasurementAloneIsEnough) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 1;
  const Window window = MakeSyntheticWindow(options);
  const Point& point = *window.keyframes[0]->points[0];
  const TermList terms = MakeDefaultTerms({});
  DepthRefiner refiner(window, terms, {});
  const DepthRefinement refined = refiner.Refine(0, point);
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
  const OutlierResult result = RemoveOutliers(MakeDefaultTerms({}), {}, &window);
  EXPECT_GE(result.points_dropped, 1);
  EXPECT_EQ(result.factors_rejected[1], 1);
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

Window TwoKeyframes(double baseline) {
  SyntheticOptions options = SmallWindow();
  options.num_keyframes = 2;
  options.baseline = baseline;
  return MakeSyntheticWindow(options);
}

EpipolarSearchResult SearchInSecondKeyframe(const Window& window,
                                            const Point& point,
                                            double rho_min,
                                            double rho_max,
                                            const EpipolarSearchOptions& search) {
  const FramePair pair =
      MakeFramePair(window.noise, window.keyframes[0]->state, window.keyframes[1]->state);
  return SearchEpipolarLine(window.camera,
                            point.patch,
                            pair,
                            window.keyframes[1]->frame->image[0],
                            rho_min,
                            rho_max,
                            search);
}

// Looks for all points of the first keyframe in the second, between two multiples of their rho.
struct SearchCount {
  int found = 0;
  int wrong = 0;  // by more than `tolerance`
};
SearchCount SearchAll(double min_factor,
                      double max_factor,
                      double tolerance,
                      const EpipolarSearchOptions& search) {
  const Window window = TwoKeyframes(0.1);
  SearchCount count;
  for (const auto& point : window.keyframes[0]->points) {
    const EpipolarSearchResult match = SearchInSecondKeyframe(
        window, *point, min_factor * point->rho, max_factor * point->rho, search);
    if (match.status != EpipolarSearchStatus::kFound) continue;
    ++count.found;
    count.wrong += std::abs(match.rho / point->rho - 1) > tolerance;
  }
  return count;
}

TEST(SearchEpipolarLine, FindsTheTrueDepthInAWideInterval) {
  const SearchCount count = SearchAll(0.6, 1.6, 0.02, {});
  EXPECT_GT(count.found, 50);
  EXPECT_LT(count.wrong, count.found / 10);
}

TEST(SearchEpipolarLine, SearchesTheFarEndOfALineThatIsTooLong) {
  // Points are at 2 m. To 0.1 m, lines would be some 10 times as long.
  EpipolarSearchOptions search;
  search.max_length = 25;
  const SearchCount count = SearchAll(0.7, 20, 0.05, search);
  EXPECT_GT(count.found, 30);
  EXPECT_LT(count.wrong, count.found / 8);
}

TEST(SearchEpipolarLine, SaysWhenTheParallaxIsTooSmall) {
  const Window window = TwoKeyframes(1e-4);
  EXPECT_EQ(SearchInSecondKeyframe(window, *window.keyframes[0]->points[0], 0.4, 0.6, {}).status,
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
  const TermList terms = MakeDefaultTerms({});
  DepthRefiner refiner(window, terms, {});
  const int activated =
      ActivateCandidates(candidate_options, 1, 1000, &refiner, &coverage, &window);
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
