// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// States beside poses and depths, as a term of somebody else's adds them.
#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "prism/factors/default_terms.h"
#include "prism/window/optimize.h"
#include "prism/window/retirement.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

// One offset of all measured 1/v for the run, known to 0.01, and a number for each keyframe that
// should be the keyframe's height. Positions along x are known (the plane alone tells the offset
// badly from the scale).
class OffsetTerm : public Term {
 public:
  explicit OffsetTerm(const Window& truth) {
    for (const auto& keyframe : truth.keyframes) {
      x_.push_back(keyframe->state.pose().translation().x());
    }
  }

  std::string name() const override { return "offset"; }

  void AddStates(Window* window) const override {
    if (window->states.empty()) {
      window->states.push_back({Kind("offset of 1/v", BlockLifetime::kRun),
                                Eigen::VectorXd::Zero(1),
                                Eigen::VectorXd::Zero(1),
                                Eigen::VectorXd::Constant(1, 0.01)});
    }
    window->newest().states.push_back({Kind("height", BlockLifetime::kKeyframe),
                                       Eigen::VectorXd::Zero(1),
                                       Eigen::VectorXd::Zero(1),
                                       Eigen::VectorXd::Constant(1, 10)});
  }

  void AddFactors(const Window& window, WindowGraph* graph) const override {
    for (size_t i = 0; i < window.keyframes.size(); ++i) {
      FactorGraph::NewFactor factor;
      factor.cost = std::make_unique<ceres::AutoDiffCostFunction<Height, 2, 9, 1>>(
          new Height{x_[window.keyframes[i]->id]});
      graph->AddFactor(std::move(factor),
                       {graph->FrameBlock(i), graph->FindBlock("height", window.keyframes[i]->id)});
    }
  }

  void AddPointFactors(const Window& window,
                       size_t /*host_index*/,
                       const Point& point,
                       int rho_block,
                       WindowGraph* graph) const override {
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<ceres::AutoDiffCostFunction<Depth, 1, 1, 1>>(
        new Depth{&point, &window.camera});
    graph->AddFactor(std::move(factor), {rho_block, graph->FindBlock("offset of 1/v")});
  }

 private:
  static BlockKindPtr Kind(const std::string& name, BlockLifetime lifetime) {
    return std::make_shared<BlockKind>(BlockKind{name, 1, lifetime});
  }
  struct Height {
    double x;
    template <typename T>
    bool operator()(const T* frame, const T* height, T* r) const {
      r[0] = (frame[5] - height[0]) / 0.001;
      r[1] = (frame[4] - x) / 1e-4;
      return true;
    }
  };
  struct Depth {
    const Point* point;
    const PlenopticProjection* camera;
    template <typename T>
    bool operator()(const T* rho, const T* offset, T* r) const {
      const T b_L = 1.0 / (1.0 / camera->f - *rho);
      r[0] = (camera->B / (b_L - camera->b_L0) + *offset - point->w_measured) / point->w_sigma;
      return true;
    }
  };

  std::vector<double> x_;
};

SyntheticOptions SmallWindow() {
  SyntheticOptions options;
  options.num_keyframes = 5;
  options.num_points = 600;
  options.width = 320;
  options.height = 240;
  options.baseline = 0.08;
  options.w_sigma = 0.001;
  return options;
}

// Keyframes come into the window one by one, as they do in a run.
Window MakeWindowWithStates(const TermList& terms) {
  Window window = MakeSyntheticWindow(SmallWindow());
  ReplayKeyframes(&window, [&](Window* w) {
    for (const auto& term : terms) term->AddStates(w);
  });
  return window;
}

TermList TermsWithOffset() {
  DefaultTermOptions options;
  options.depth_residual = false;  // OffsetTerm stands in its place
  TermList terms = MakeDefaultTerms(options);
  terms.push_back(std::make_shared<OffsetTerm>(MakeSyntheticWindow(SmallWindow())));
  return terms;
}

WindowOptions Thorough() {
  WindowOptions options;
  options.solve.max_iterations = 50;
  options.solve.function_tolerance = 1e-10;
  options.solve.threads = 1;
  return options;
}

TEST(StateBlock, OfTheRunIsEstimatedAndStaysWhenKeyframesLeave) {
  const TermList terms = TermsWithOffset();
  Window window = MakeWindowWithStates(terms);
  ASSERT_EQ(window.states.size(), 1u);
  constexpr double kOffset = 0.004;
  for (const auto& keyframe : window.keyframes) {
    ASSERT_EQ(keyframe->states.size(), 1u);
    for (const auto& point : keyframe->points) point->w_measured += kOffset;
  }
  OptimizeWindow(Thorough(), terms, &window);
  const double offset = window.states[0].value(0);
  EXPECT_NEAR(offset, kOffset, 5e-4);
  for (const auto& keyframe : window.keyframes) {
    EXPECT_NEAR(keyframe->states[0].value(0), keyframe->state.pose().translation().y(), 1e-3);
  }

  RetireKeyframe(Thorough(), terms, 0, &window);
  EXPECT_EQ(window.states.size(), 1u);
  EXPECT_TRUE(window.states[0].first_estimate.has_value());
  bool is_offset_in_prior = false;
  for (const LinearPrior::Block& block : window.prior.blocks) {
    EXPECT_FALSE(block.kind->lifetime == BlockLifetime::kKeyframe && block.owner == 0);
    is_offset_in_prior |= block.kind->name == "offset of 1/v";
  }
  EXPECT_TRUE(is_offset_in_prior);
  // What the retired points knew of the offset is kept: the optimum does not move.
  OptimizeWindow(Thorough(), terms, &window);
  EXPECT_NEAR(window.states[0].value(0), offset, 5e-4);
}

TEST(StateBlock, IsHeldByItsPriorWhereMeasurementsSayNothing) {
  const TermList terms = TermsWithOffset();
  Window window = MakeWindowWithStates(terms);
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) point->w_sigma = 1e6;
  }
  window.states[0].value(0) = 0.3;
  OptimizeWindow(Thorough(), terms, &window);
  EXPECT_NEAR(window.states[0].value(0), 0, 1e-4);
}

}  // namespace
}  // namespace prism
