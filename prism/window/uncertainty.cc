// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/uncertainty.h"

#include <cmath>

#include "prism/factors/depth_offset_term.h"
#include "prism/solver/block_covariance.h"

namespace prism {
namespace {

// d (path length) / d (states): a step of a frame's translation v moves the camera centre by
// -R^T v, a rotation does not move it.
Eigen::VectorXd PathGradient(const Window& window,
                             const WindowGraph& graph,
                             const BlockCovariance& covariance,
                             WindowUncertainty* result) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(covariance.matrix.rows());
  const auto add = [&](size_t i, const Eigen::Vector3d& direction) {
    const Eigen::Index column = covariance.column[graph.FrameBlock(i)];
    if (column < 0) return;
    const SE3 pose = FrameState(graph.values(graph.FrameBlock(i))).pose();
    gradient.segment<3>(column) -= pose.rotation() * direction;
  };
  for (size_t i = 1; i < window.keyframes.size(); ++i) {
    const auto centre = [&](size_t k) -> Eigen::Vector3d {
      return FrameState(graph.values(graph.FrameBlock(k))).pose().Inverse().translation();
    };
    const Eigen::Vector3d step = centre(i) - centre(i - 1);
    const double length = step.norm();
    result->path_m += length;
    result->newest_step_m = length;
    if (!(length > 0)) continue;
    add(i, step / length);
    add(i - 1, -step / length);
  }
  return gradient;
}

// d ln(path length) / d (a shift that all measured 1/v have in common): the window can but grow
// with it, by what fits the shifted depths best.
double ScaleChangePerDepthShift(const Window& window) {
  double sum = 0, square_sum = 0;
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) {
      if (!(point->w_sigma > 0 && point->rho > 0)) continue;
      double dw_drho;
      InverseVirtualDepth(window.camera, point->rho, &dw_drho);
      const double dw_dlog_scale = -dw_drho * point->rho / point->w_sigma;
      sum += dw_dlog_scale / point->w_sigma;
      square_sum += dw_dlog_scale * dw_dlog_scale;
    }
  }
  return square_sum > 0 ? sum / square_sum : 0;
}

}  // namespace

std::optional<WindowUncertainty> EvaluateUncertainty(const Window& window,
                                                     const WindowGraph& graph) {
  if (window.keyframes.size() < 2) return std::nullopt;
  const std::optional<BlockCovariance> covariance = EvaluateBlockCovariance(graph);
  if (!covariance) return std::nullopt;
  WindowUncertainty result;
  const Eigen::VectorXd gradient = PathGradient(window, graph, *covariance, &result);
  if (!(result.path_m > 0)) return std::nullopt;
  result.scale_sigma =
      std::sqrt(gradient.dot(covariance->matrix.lazyProduct(gradient))) / result.path_m;

  const auto variance = [&](int block) {
    const Eigen::Index column = covariance->column[block];
    return covariance->matrix(column, column);
  };
  const int newest = PersistentDepthOffsetBlock(graph, window.newest());
  if (newest >= 0) {
    result.depth_offset = *graph.values(newest);
    result.depth_offset_sigma = std::sqrt(variance(newest));
  }
  double sum = 0;
  for (const auto& keyframe : window.keyframes) {
    const int offset = DepthOffsetBlock(graph, *keyframe);
    if (offset < 0) continue;
    const int persistent = PersistentDepthOffsetBlock(graph, *keyframe);
    double own = *graph.values(offset), own_variance = variance(offset);
    if (persistent >= 0 && persistent != offset) {
      own -= *graph.values(persistent);
      own_variance += variance(persistent) - 2 * covariance->matrix(covariance->column[offset],
                                                                    covariance->column[persistent]);
    }
    sum += own * own + own_variance;
  }
  result.keyframe_offset_square = sum / static_cast<double>(window.keyframes.size());
  if (sum > 0 && newest < 0) {
    // What all keyframes share is no state then, but it is not 0 either.
    result.scale_sigma = std::hypot(
        result.scale_sigma, ScaleChangePerDepthShift(window) * window.noise.DepthOffsetSigma());
  }
  return result;
}

}  // namespace prism
