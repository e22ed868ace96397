// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/transferred_depth.h"

#include <gtest/gtest.h>

#include "../window/synthetic_window.h"
#include "prism/factors/default_terms.h"
#include "prism/factors/inverse_virtual_depth_term.h"

namespace prism {
namespace {

class TransferOfDepth : public ::testing::TestWithParam<FocusedImage> {
 protected:
  TransferOfDepth() : camera_(SyntheticCamera(SyntheticOptions())) {
    camera_.image = GetParam();
    Vector6d tangent;
    tangent << 0.1, -0.05, 0.2, 0.03, -0.08, 0.05;
    const SE3 pose = SE3::Exp(tangent);
    motion_ = RigidMotion(pose);
  }

  PlenopticProjection camera_;
  RigidMotion motion_;
  const Eigen::Vector2d px_{420, 90};
};

TEST_P(TransferOfDepth, InvertsTheProjectionBetweenFrames) {
  for (const double z : {0.7, 2.0, 8.0}) {
    Eigen::Vector3d x_V;
    ASSERT_TRUE(ProjectBetweenFrames(camera_, px_, 1 / z, motion_, &x_V));
    const auto depth = TransferDepth(camera_, motion_, px_, 1 / x_V.z());
    ASSERT_TRUE(depth.has_value());
    EXPECT_NEAR(depth->w, InverseVirtualDepth(camera_, 1 / z), 1e-9) << z;
  }
}

TEST_P(TransferOfDepth, GainIsItsDerivativeAlsoBeyondInfinity) {
  const double infinity = InverseVirtualDepthAtInfinity(camera_);
  const double step = 1e-6;
  for (const double w : {infinity - 0.05, infinity - 0.01, infinity, infinity + 0.003}) {
    const auto depth = TransferDepth(camera_, motion_, px_, w);
    const auto after = TransferDepth(camera_, motion_, px_, w + step);
    ASSERT_TRUE(depth && after);
    EXPECT_NEAR((after->w - depth->w) / step, depth->gain, 1e-3) << w;
  }
}

TEST_P(TransferOfDepth, IsNothingFromBehindThePoint) {
  motion_.t.z() = -3;
  Eigen::Vector3d x_V;
  EXPECT_FALSE(ProjectBetweenFrames(camera_, px_, 1 / 2.0, motion_, &x_V));
  motion_ = RigidMotion();
  motion_.R = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  motion_.t.setZero();
  EXPECT_FALSE(TransferDepth(camera_, motion_, px_, 0.4).has_value());
}

INSTANTIATE_TEST_SUITE_P(Images,
                         TransferOfDepth,
                         ::testing::Values(FocusedImage::kVirtualPoints, FocusedImage::kChiefRays));

TEST(InverseVirtualDepthCost, OffsetEntersByItsGain) {
  const PlenopticProjection camera(SyntheticCamera(SyntheticOptions()));
  const InverseVirtualDepthCost cost(0.4, 0.002, 0.7, &camera);
  const double rho = 0.4, zero = 0, offset = 0.001;
  double at_zero = 0, at_offset = 0, slope = 0;
  const double* const without[] = {&rho, &zero};
  const double* const with[] = {&rho, &offset};
  double* jacobians[] = {nullptr, &slope};
  ASSERT_TRUE(cost.Evaluate(without, &at_zero, nullptr));
  ASSERT_TRUE(cost.Evaluate(with, &at_offset, jacobians));
  EXPECT_NEAR(at_offset - at_zero, 0.7 * 0.001 / 0.002, 1e-9);
  EXPECT_NEAR(slope, 0.7 / 0.002, 1e-9);
}

class DepthsOfOtherKeyframes : public ::testing::Test {
 protected:
  DepthsOfOtherKeyframes() : window_(Make()) {}

  static Window Make() {
    SyntheticOptions options;
    options.num_keyframes = 3;
    options.num_points = 60;
    options.has_depth_images = true;
    return MakeSyntheticWindow(options);
  }
  // Of factors of depth, by keyframe.
  int NumFactorsOf(const Window& window, const InverseVirtualDepthTermOptions& options) const {
    const auto graph =
        BuildWindowGraph(window, {std::make_shared<InverseVirtualDepthTerm>(options)}, {});
    return static_cast<int>(graph->factors().size());
  }

  Window window_;
};

TEST_F(DepthsOfOtherKeyframes, AreMeasurementsOfAPointToo) {
  InverseVirtualDepthTermOptions options;
  const int all = NumFactorsOf(window_, options);
  EXPECT_GT(all, 2 * window_.NumPoints());
  options.of_all_keyframes = false;
  EXPECT_EQ(NumFactorsOf(window_, options), window_.NumPoints());
  const auto graph = BuildWindowGraph(
      window_, {std::make_shared<InverseVirtualDepthTerm>(InverseVirtualDepthTermOptions())}, {});
  for (const FactorGraph::Factor& factor : graph->factors()) {
    const double* rho = graph->values(graph->BlocksOf(factor)[0]);
    double residual = 0;
    ASSERT_TRUE(factor.cost->Evaluate(&rho, &residual, nullptr));
    // Exact in other keyframes but for the slope of the plane within half a pixel; measured with
    // noise in the host.
    EXPECT_LT(std::abs(residual), 5);
    EXPECT_FALSE(graph->TiesFrame(factor));
  }
}

TEST_F(DepthsOfOtherKeyframes, AreForgottenOneByOne) {
  const InverseVirtualDepthTerm term{InverseVirtualDepthTermOptions()};
  Point& point = *window_.keyframes[0]->points[0];
  const int before = NumFactorsOf(window_, {});
  FactorGraph::Factor factor{};
  factor.group = window_.keyframes[2]->id;
  term.Reject(factor, &point, &window_);
  EXPECT_GT(point.w_sigma, 0);
  EXPECT_EQ(NumFactorsOf(window_, {}), before - 1);
  factor.group = InverseVirtualDepthTerm::kHost;
  term.Reject(factor, &point, &window_);
  EXPECT_EQ(point.w_sigma, 0);
  EXPECT_EQ(NumFactorsOf(window_, {}), before - 2);
}

}  // namespace
}  // namespace prism
