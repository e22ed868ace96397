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
  WindowProblem(const WindowOptions& options, const Window& window);
  void CopyTo(Window* window) const;

  // Ceres orders parameter blocks by address: in these arrays it always finds the same order, so
  // that the result does not depend on where the heap put keyframes and points.
  std::vector<FrameState> states;
  std::vector<double> rho;  // of all points, keyframe by keyframe
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

std::vector<FrameState> CopyStates(const Window& window) {
  std::vector<FrameState> states;
  for (const auto& keyframe : window.keyframes) states.push_back(keyframe->state);
  return states;
}

std::vector<double> CopyInverseDepths(const Window& window) {
  std::vector<double> rho;
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) rho.push_back(point->rho);
  }
  return rho;
}

WindowProblem::WindowProblem(const WindowOptions& options, const Window& window)
    : states(CopyStates(window)),
      rho(CopyInverseDepths(window)),
      pairs(window, states, options.first_estimate_jacobians),
      manifold(!options.affine_brightness),
      problem(ProblemOptions(&pairs)),
      ordering(std::make_shared<ceres::ParameterBlockOrdering>()) {
  if (options.robust_loss) {
    photometric_loss = std::make_unique<ceres::HuberLoss>(options.photometric_huber *
                                                          std::sqrt(double{kPatternSize}));
    depth_loss = std::make_unique<ceres::HuberLoss>(options.depth_huber);
  }
  for (FrameState& state : states) {
    problem.AddParameterBlock(state.data(), FrameState::kSize, &manifold);
    ordering->AddElementToGroup(state.data(), 1);
  }
  const auto& keyframes = window.keyframes;
  double* point_rho = rho.data();
  for (size_t i = 0; i < keyframes.size(); ++i) {
    std::vector<SE3> target_from_host;
    for (const FrameState& state : states) {
      target_from_host.push_back(state.pose() * states[i].pose().Inverse());
    }
    for (const auto& point : keyframes[i]->points) {
      bool is_constrained = false;
      for (size_t j = 0; j < keyframes.size(); ++j) {
        if (i == j || !IsObserved(window.camera, target_from_host[j], *point, *keyframes[j])) {
          continue;
        }
        photometric_blocks.push_back(problem.AddResidualBlock(
            new PhotometricCost(
                &point->patch, &pairs.pair(i, j), keyframes[j]->frame->image[0], &window.camera),
            photometric_loss.get(),
            states[i].data(),
            states[j].data(),
            point_rho));
        is_constrained = true;
      }
      if (options.depth_residual && point->w_sigma > 0) {
        depth_blocks.push_back(problem.AddResidualBlock(
            new InverseVirtualDepthCost(point->w_measured, point->w_sigma, &window.camera),
            depth_loss.get(),
            point_rho));
        is_constrained = true;
      }
      if (is_constrained) ordering->AddElementToGroup(point_rho, 0);
      ++point_rho;
    }
  }
  if (options.marginalization_prior && !window.prior.empty()) {
    std::vector<double*> prior_states;
    for (const int id : window.prior_keyframe_ids) {
      for (size_t i = 0; i < keyframes.size(); ++i) {
        if (keyframes[i]->id == id) prior_states.push_back(states[i].data());
      }
    }
    problem.AddResidualBlock(new LinearPriorCost(&window.prior), nullptr, prior_states);
  } else {
    problem.SetParameterBlockConstant(states.front().data());
  }
}

void WindowProblem::CopyTo(Window* window) const {
  const double* point_rho = rho.data();
  for (size_t i = 0; i < states.size(); ++i) {
    window->keyframes[i]->state = states[i];
    for (const auto& point : window->keyframes[i]->points) point->rho = *point_rho++;
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
  WindowProblem built(options, *window);
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
  built.CopyTo(window);
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
