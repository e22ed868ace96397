// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/optimize.h"

#include <cmath>
#include <memory>

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "prism/residual/frame_manifold.h"
#include "prism/residual/inverse_virtual_depth.h"
#include "prism/residual/photometric.h"
#include "prism/window/pair_table.h"

namespace prism {
namespace {

// The problem and what its residual blocks point to.
struct WindowProblem {
  WindowProblem(const WindowOptions& options, Window* window);

  PairTable pairs;
  FrameManifold manifold;
  std::unique_ptr<ceres::LossFunction> photometric_loss;
  std::unique_ptr<ceres::LossFunction> depth_loss;
  ceres::Problem problem;
  std::vector<ceres::ResidualBlockId> photometric_blocks;
  std::vector<ceres::ResidualBlockId> depth_blocks;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering;
};

ceres::Problem::Options ProblemOptions(PairTable* pairs) {
  ceres::Problem::Options options;
  options.evaluation_callback = pairs;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

WindowProblem::WindowProblem(const WindowOptions& options, Window* window)
    : pairs(*window, options.first_estimate_jacobians),
      manifold(!options.affine_brightness),
      problem(ProblemOptions(&pairs)),
      ordering(std::make_shared<ceres::ParameterBlockOrdering>()) {
  if (options.robust_loss) {
    photometric_loss = std::make_unique<ceres::HuberLoss>(options.photometric_huber *
                                                          std::sqrt(double{kPatternSize}));
    depth_loss = std::make_unique<ceres::HuberLoss>(options.depth_huber);
  }
  const auto& keyframes = window->keyframes;
  for (const auto& keyframe : keyframes) {
    problem.AddParameterBlock(keyframe->state.data(), FrameState::kSize, &manifold);
    ordering->AddElementToGroup(keyframe->state.data(), 1);
  }
  for (size_t i = 0; i < keyframes.size(); ++i) {
    for (const auto& point : keyframes[i]->points) {
      const size_t blocks_before = photometric_blocks.size();
      for (size_t j = 0; j < keyframes.size(); ++j) {
        if (i == j || !IsObserved(*window, *keyframes[i], *point, *keyframes[j])) continue;
        photometric_blocks.push_back(problem.AddResidualBlock(
            new PhotometricCost(
                &point->patch, &pairs.pair(i, j), keyframes[j]->frame->image[0], &window->camera),
            photometric_loss.get(),
            keyframes[i]->state.data(),
            keyframes[j]->state.data(),
            &point->rho));
      }
      const bool has_depth = options.depth_residual && point->w_sigma > 0;
      if (has_depth) {
        depth_blocks.push_back(problem.AddResidualBlock(
            new InverseVirtualDepthCost(point->w_measured, point->w_sigma, &window->camera),
            depth_loss.get(),
            &point->rho));
      }
      if (has_depth || photometric_blocks.size() > blocks_before) {
        ordering->AddElementToGroup(&point->rho, 0);
      }
    }
  }
  if (options.marginalization_prior && !window->prior.empty()) {
    std::vector<double*> states;
    for (const int id : window->prior_keyframe_ids) {
      for (const auto& keyframe : keyframes) {
        if (keyframe->id == id) states.push_back(keyframe->state.data());
      }
    }
    problem.AddResidualBlock(new LinearPriorCost(&window->prior), nullptr, states);
  } else {
    problem.SetParameterBlockConstant(keyframes.front()->state.data());
  }
}

// Mean of weight * squared residual over the residuals of some blocks, weight = rho'(s) of the
// loss.
double VarianceFactor(const ceres::Problem& problem,
                      const std::vector<ceres::ResidualBlockId>& blocks,
                      const ceres::LossFunction* loss,
                      int residuals_per_block) {
  double sum = 0;
  for (const ceres::ResidualBlockId block : blocks) {
    double cost;
    if (!const_cast<ceres::Problem&>(problem).EvaluateResidualBlockAssumingParametersUnchanged(
            block, /*apply_loss_function=*/false, &cost, nullptr, nullptr)) {
      continue;
    }
    double rho[3] = {2 * cost, 1, 0};
    if (loss != nullptr) loss->Evaluate(2 * cost, rho);
    sum += rho[1] * 2 * cost;
  }
  return blocks.empty() ? 0 : sum / (static_cast<double>(blocks.size()) * residuals_per_block);
}

}  // namespace

OptimizationResult OptimizeWindow(const WindowOptions& options, Window* window) {
  WindowProblem built(options, window);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = built.ordering;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.threads;
  solver.function_tolerance = options.function_tolerance;
  solver.jacobi_scaling = false;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &built.problem, &summary);

  built.pairs.Update();
  OptimizationResult result;
  result.usable = summary.IsSolutionUsable();
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.photometric_residuals = static_cast<int>(built.photometric_blocks.size());
  result.depth_residuals = static_cast<int>(built.depth_blocks.size());
  result.variance_factors.photometric = VarianceFactor(
      built.problem, built.photometric_blocks, built.photometric_loss.get(), kPatternSize);
  result.variance_factors.depth =
      VarianceFactor(built.problem, built.depth_blocks, built.depth_loss.get(), 1);
  result.rms = options.photometric.intensity_sigma * std::sqrt(result.variance_factors.photometric);
  return result;
}

}  // namespace prism
