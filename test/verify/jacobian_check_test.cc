// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/verify/jacobian_check.h"

#include <string>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include "prism/factors/default_terms.h"

namespace prism {
namespace {

PlenopticCamera TestCamera() {
  PlenopticCamera lens;
  lens.focal_length = 16.748e-3;
  lens.main_lens_mla_distance = 15.893e-3;
  lens.sensor_mla_distance = 0.376e-3;
  return PlenopticFromPinhole({320, 240, 262.5, 262.5, 160, 120}, lens);
}

PlenopticCamera KeplerianCamera() {
  PlenopticCamera camera = TestCamera();
  camera.mode = MicroLensMode::kKeplerian;
  camera.main_lens_mla_distance = 18.064e-3;
  return camera;
}

PlenopticCamera OfChiefRays() {
  PlenopticCamera camera = TestCamera();
  camera.focused_image = FocusedImage::kChiefRays;
  return camera;
}

class JacobiansOf : public ::testing::TestWithParam<PlenopticCamera> {};

INSTANTIATE_TEST_SUITE_P(Modes,
                         JacobiansOf,
                         ::testing::Values(TestCamera(), KeplerianCamera(), OfChiefRays()),
                         [](const auto& test) {
                           return std::string(ToString(test.param.mode)) + "_" +
                                  ToString(test.param.focused_image);
                         });

TEST_P(JacobiansOf, AllResidualsAgreeWithAutodiffAndNumericDifferences) {
  const JacobianCheckResult result = CheckJacobians(GetParam(), MakeDefaultTerms({}), {});
  EXPECT_GT(result.valid_samples, 50);
  for (const JacobianBlockCheck& block : result.blocks) {
    EXPECT_LT(block.autodiff_error.value_or(0), 1e-8) << block.residual << ", " << block.block;
    EXPECT_LT(block.numeric_error, 1e-5) << block.residual << ", " << block.block;
    EXPECT_GT(block.largest_element, 0) << block.residual << ", " << block.block;
  }
  EXPECT_TRUE(result.agrees);
}

TEST(Jacobians, PrintedEquation66IsOffByTheFocalLength) {
  const PlenopticCamera camera = TestCamera();
  const JacobianCheckResult result = CheckJacobians(camera, {}, {});
  const PrintedElement& last = result.printed.back();
  EXPECT_EQ(last.equation, "(66)");
  // The printed row also has the sign that Eq. (72) has; the true one is Eq. (66)'s first line.
  EXPECT_NEAR(std::abs(last.printed / last.analytic), 1 / camera.focal_length, 1e-6);
}

// A term whose analytic derivative is wrong by one per cent.
class WrongCost : public ceres::SizedCostFunction<1, 1> {
 public:
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const double rho = parameters[0][0];
    residuals[0] = rho * rho;
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 2.02 * rho;
    return true;
  }
};

class WrongTerm : public Term {
 public:
  std::string name() const override { return "wrong"; }
  void AddPointFactors(const Window& /*window*/,
                       size_t /*host_index*/,
                       const Point& /*point*/,
                       int rho_block,
                       WindowGraph* graph) const override {
    FactorGraph::NewFactor factor;
    factor.cost = std::make_unique<WrongCost>();
    graph->AddFactor(std::move(factor), {rho_block});
  }
};

TEST(Jacobians, AWrongDerivativeOfATermOfOnesOwnIsFound) {
  TermList terms = MakeDefaultTerms({});
  terms.push_back(std::make_shared<WrongTerm>());
  const JacobianCheckResult result = CheckJacobians(TestCamera(), terms, {});
  EXPECT_FALSE(result.agrees);
  for (const JacobianBlockCheck& block : result.blocks) {
    EXPECT_EQ(Agrees(block, {}), block.residual != "term: wrong") << block.residual;
  }
}

}  // namespace
}  // namespace prism
