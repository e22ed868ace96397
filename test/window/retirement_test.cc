// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/retirement.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "prism/factors/default_terms.h"
#include "prism/window/optimize.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

constexpr int kTangent = FrameState::kTangentSize;

SyntheticOptions SmallWindow() {
  SyntheticOptions options;
  options.num_keyframes = 5;
  options.num_points = 250;
  options.width = 320;
  options.height = 240;
  options.baseline = 0.04;
  return options;
}

// The directions of the gauge at the prior's linearisation points, unit length: 6 rigid motions of
// the world (delta_i = Ad(T_i) xi), and the change of scale about the front focal point
// (delta_i = [t_i - c; 0], c = (0, 0, f_L): the centre of projection of the focused image).
Eigen::MatrixXd GaugeDirections(const Window& window) {
  const auto n = static_cast<Eigen::Index>(window.prior.blocks.size());
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(kTangent * n, 7);
  for (Eigen::Index i = 0; i < n; ++i) {
    const SE3 pose(window.prior.blocks[i].linearization.data());
    N.block<6, 6>(kTangent * i, 0) = pose.Adjoint();
    N.block<3, 1>(kTangent * i, 6) = pose.translation() - Eigen::Vector3d(0, 0, window.camera.f);
  }
  // A change of scale is told apart from a shift of the world by projecting the others out.
  for (int column = 0; column < 7; ++column) {
    for (int pass = 0; pass < 2; ++pass) {
      for (int other = 0; other < column; ++other) {
        N.col(column) -= N.col(other).dot(N.col(column)) * N.col(other);
      }
      N.col(column).normalize();
    }
  }
  return N;
}

// |A n|^2 over the largest eigenvalue of A^T A, for each gauge direction n.
Eigen::VectorXd GaugeInformation(const Window& window) {
  const Eigen::MatrixXd H = window.prior.A.transpose() * window.prior.A;
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H).eigenvalues().tail(1)(0);
  return (window.prior.A * GaugeDirections(window)).colwise().squaredNorm().transpose() / largest;
}

// Retires the two oldest keyframes one after the other; the states move in between, as they do when
// the window is optimised.
Window RetireTwo(const WindowOptions& options) {
  Window window = MakeSyntheticWindow(SmallWindow());
  RetireKeyframe(options, MakeDefaultTerms({}), 0, &window);
  PerturbWindow(0.01, 0.005, 0, &window);
  RetireKeyframe(options, MakeDefaultTerms({}), 1, &window);
  return window;
}

TEST(RetireKeyframe, WithoutDepthResidualsTheGaugeHasSevenDirections) {
  DefaultTermOptions term_options;
  term_options.depth_residual = false;
  Window window = MakeSyntheticWindow(SmallWindow());
  RetireKeyframe({}, MakeDefaultTerms(term_options), 0, &window);
  const Eigen::VectorXd information = GaugeInformation(window);
  for (int i = 0; i < 7; ++i) EXPECT_LT(information(i), 1e-11) << "direction " << i;
}

TEST(RetireKeyframe, DepthResidualsMakeTheScaleObservable) {
  Window window = MakeSyntheticWindow(SmallWindow());
  RetireKeyframe({}, MakeDefaultTerms({}), 0, &window);
  const Eigen::VectorXd information = GaugeInformation(window);
  for (int i = 0; i < 6; ++i) EXPECT_LT(information(i), 1e-11) << "direction " << i;
  EXPECT_GT(information(6), 1e-10);
}

TEST(RetireKeyframe, FirstEstimatesKeepTheGaugeFreeAndWithoutThemItIsLost) {
  WindowOptions options;
  const Eigen::VectorXd with = GaugeInformation(RetireTwo(options));
  options.graph.first_estimates = false;
  const Eigen::VectorXd without = GaugeInformation(RetireTwo(options));
  for (int i = 0; i < 6; ++i) EXPECT_LT(with(i), 1e-11) << "direction " << i;
  EXPECT_GT(without.head<6>().maxCoeff(), 1e3 * with.head<6>().maxCoeff());
  EXPECT_GT(without.head<6>().maxCoeff(), 1e-9);
}

TEST(RetireKeyframe, ThePriorSpeaksOfTheKeyframesThatRemain) {
  Window window = MakeSyntheticWindow(SmallWindow());
  const RetirementResult result = RetireKeyframe({}, MakeDefaultTerms({}), 0, &window);
  EXPECT_EQ(window.keyframes.size(), 4u);
  ASSERT_EQ(window.prior.blocks.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(window.prior.blocks[i].owner, i + 1);
  EXPECT_EQ(window.prior.A.cols(), 4 * kTangent);
  EXPECT_GT(result.marginalized_points, 20);
  EXPECT_EQ(static_cast<int>(result.points.size()), result.marginalized_points);
  for (const auto& keyframe : window.keyframes) EXPECT_TRUE(keyframe->first_estimate.has_value());
  EXPECT_LE(result.rank.rank, 4 * kTangent - 6);
}

TEST(RetireKeyframe, ThePriorPullsBackWhatTheRetiredPointsKnew) {
  // Keyframes keep no point of their own: only the prior ties them to each other.
  SyntheticOptions synthetic = SmallWindow();
  synthetic.w_sigma = 0.0005;
  Window window = MakeSyntheticWindow(synthetic);
  for (size_t i = 1; i < window.keyframes.size(); ++i) window.keyframes[i]->points.clear();
  RetireKeyframe({}, MakeDefaultTerms({}), 0, &window);
  WindowOptions options;
  options.solve.max_iterations = 30;
  options.solve.function_tolerance = 1e-10;
  const auto relative_pose = [&] {
    return window.keyframes[3]->state.pose() * window.keyframes[0]->state.pose().Inverse();
  };
  OptimizeWindow(options, MakeDefaultTerms({}), &window);
  const SE3 before = relative_pose();
  window.keyframes[3]->state.set_pose(
      SE3::Exp((Vector6d() << 0.01, 0, 0.005, 0, 0.003, 0).finished()) *
      window.keyframes[3]->state.pose());
  OptimizeWindow(options, MakeDefaultTerms({}), &window);
  EXPECT_LT((relative_pose() * before.Inverse()).Log().norm(), 1e-4);
}

TEST(RetireKeyframe, WithoutThePriorNothingIsRemembered) {
  WindowOptions options;
  options.marginalization_prior = false;
  Window window = MakeSyntheticWindow(SmallWindow());
  RetireKeyframe(options, MakeDefaultTerms({}), 0, &window);
  EXPECT_TRUE(window.prior.empty());
  EXPECT_EQ(window.keyframes.size(), 4u);
}

TEST(KeyframesToRetire, KeepsTheTwoNewestAndTheWindowLength) {
  SyntheticOptions synthetic = SmallWindow();
  synthetic.num_keyframes = 6;
  const Window window = MakeSyntheticWindow(synthetic);
  WindowOptions options;
  options.max_keyframes = 4;
  const std::vector<int> ids = KeyframesToRetire(options, {}, window);
  // With the next one, four are optimised.
  ASSERT_EQ(ids.size(), 3u);
  for (const int id : ids) EXPECT_LT(id, 4);
}

TEST(KeyframesToRetire, ABrightnessTooFarOffRetires) {
  Window window = MakeSyntheticWindow(SmallWindow());
  window.keyframes[1]->state = FrameState(window.keyframes[1]->state.pose(), 1.6, 0);
  EXPECT_EQ(KeyframesToRetire({}, {}, window), std::vector<int>{1});
}

}  // namespace
}  // namespace prism
