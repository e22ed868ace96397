// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/level_alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "prism/tracking/alignment_kernel.h"

namespace prism {

namespace {

size_t WholeBatches(size_t size) { return (size + kPixelBatch - 1) / kPixelBatch * kPixelBatch; }

// The depths of a batch of pixels, one a pixel.
void ExpandDepths(const std::vector<double>& rho, size_t first, int pixels_per_point, double* out) {
  if (pixels_per_point == 1) {
    std::copy_n(rho.data() + first, kPixelBatch, out);
    return;
  }
  for (size_t i = 0; i < kPixelBatch; ++i) out[i] = rho[(first + i) / pixels_per_point];
}

// Adds `sign` times a sum of products of columns: 8 of the state, then the gradient.
void Add(const Gram& gram,
         double sign,
         Eigen::Matrix<double, 8, 8>* H,
         Eigen::Matrix<double, 8, 1>* g) {
  const double* product = gram.data();
  for (int row = 0; row < 8; ++row) {
    for (int column = row; column < 8; ++column) {
      (*H)(row, column) += sign * *product;
      if (column > row) (*H)(column, row) += sign * *product;
      ++product;
    }
    (*g)[row] += sign * *product++;
  }
}

}  // namespace

// Of half the energy, over [pose; a; b] and the inverse depth of each point.
struct LevelAlignment::NormalEquations {
  Matrix8d H = Matrix8d::Zero();
  Vector8d g = Vector8d::Zero();
  std::vector<double> columns, H_points;  // see PointColumns

  PointColumns Points(size_t stride) {
    columns.resize(kNumColumns * stride, 0);
    H_points.resize(stride, 0);
    return {columns.data(), H_points.data(), stride};
  }
};

LevelAlignment::LevelAlignment(const TrackingReference& reference,
                               const ImageViewF& target_image,
                               int level,
                               const NoiseModel& noise,
                               const LevelAlignmentOptions& options,
                               double widening,
                               const PosePrior* prior)
    : reference_(reference),
      level_(reference.levels[level]),
      camera_(reference.cameras[level]),
      image_(target_image),
      options_(options),
      prior_(prior),
      sigma_(noise.FitSigma()),
      huber_threshold_(options.robust ? options.huber * sigma_ : INFINITY),
      outlier_threshold_(widening * options.outlier * sigma_),
      known_rho_(WholeBatches(reference.points.size()), 0),
      prior_root_(known_rho_.size(), 0) {
  for (size_t i = 0; i < reference.points.size(); ++i) {
    const ReferencePoint& point = reference.points[i];
    known_rho_[i] = point.rho;
    if (point.rho_sigma > 0 && !point.is_excluded) prior_root_[i] = sigma_ / point.rho_sigma;
  }
}

LevelCost LevelAlignment::Evaluate(const AlignmentState& state) const {
  return Evaluate(state, known_rho_, false, nullptr);
}

LevelCost LevelAlignment::Evaluate(const AlignmentState& state,
                                   const std::vector<double>& rho) const {
  return Evaluate(state, rho, false, nullptr);
}

LevelCost LevelAlignment::Evaluate(const AlignmentState& state,
                                   const std::vector<double>& rho,
                                   bool free_depths,
                                   NormalEquations* equations) const {
  std::vector<double> rho_of_point = rho;
  rho_of_point.resize(known_rho_.size(), 0);
  for (size_t i = 0; i < reference_.points.size(); ++i) {
    if (reference_.points[i].is_excluded) rho_of_point[i] = NAN;
  }
  PointColumns points = {nullptr, nullptr, known_rho_.size()};
  if (equations != nullptr && free_depths) points = equations->Points(known_rho_.size());
  const RelativeState relative{state.target_from_reference, std::exp(state.a), state.b};
  const ReferencePixels& pixels = level_.pixels;
  const bool is_pattern = level_.pixels_per_point > 1;
  RobustSum sum;
  Gram gram{};
  PixelResiduals residuals;
  alignas(64) double rho_of_pixel[kPixelBatch], weights[kPixelBatch];
  for (size_t first = 0; first < pixels.size(); first += kPixelBatch) {
    ExpandDepths(rho_of_point, first, level_.pixels_per_point, rho_of_pixel);
    EvaluatePixels(
        pixels, first, rho_of_pixel, relative, camera_, image_, equations != nullptr, &residuals);
    WeighPixels(residuals,
                pixels.weight() + first,
                huber_threshold_,
                outlier_threshold_,
                equations != nullptr ? weights : nullptr,
                &sum);
    if (equations == nullptr) continue;
    AddGram(residuals.rows[0], kPixelBatch, weights, kPixelBatch, &gram);
    if (free_depths) {
      SetPoints(residuals, weights, is_pattern, first / level_.pixels_per_point, points);
    }
  }
  // In the unit of the residuals.
  AddDepthPriors(rho_of_point.data(),
                 known_rho_.data(),
                 prior_root_.data(),
                 options_.robust ? options_.depth_huber * sigma_ : INFINITY,
                 points,
                 &sum);
  LevelCost cost = {sum.energy, static_cast<int>(sum.visible), static_cast<int>(sum.inliers)};
  if (equations != nullptr) {
    equations->H.setZero();
    equations->g.setZero();
    Add(gram, 1, &equations->H, &equations->g);
  }
  if (prior_ != nullptr) {
    const Vector6d step =
        (state.target_from_reference * prior_->target_from_reference.Inverse()).Log();
    const Matrix6d information = sigma_ * sigma_ * prior_->information;
    cost.energy += step.dot(information * step);
    if (equations != nullptr) {
      equations->H.topLeftCorner<6, 6>() += information;
      equations->g.head<6>() += information * step;
    }
  }
  return cost;
}

std::vector<double> LevelAlignment::EliminateDepths(const NormalEquations& equations,
                                                    double lambda,
                                                    Matrix8d* S,
                                                    Vector8d* g) const {
  std::vector<double> inverse(known_rho_.size(), 0);
  for (size_t i = 0; i < inverse.size(); ++i) {
    if (prior_root_[i] > 0) inverse[i] = 1 / ((1 + lambda) * equations.H_points[i]);
  }
  Gram eliminated{};
  AddGram(equations.columns.data(), inverse.size(), inverse.data(), inverse.size(), &eliminated);
  Add(eliminated, -1, S, g);
  return inverse;
}

Matrix6d LevelAlignment::PoseInformation(const AlignmentState& state,
                                         const std::vector<double>& rho,
                                         bool free_depths) const {
  NormalEquations equations;
  Evaluate(state, rho, free_depths, &equations);
  Matrix8d S = equations.H;
  Vector8d g = equations.g;
  if (free_depths) EliminateDepths(equations, 0, &S, &g);
  Matrix6d pose = S.topLeftCorner<6, 6>();
  if (options_.affine_brightness) {
    // Regularised: a level without a pixel in view says nothing of brightness.
    const Eigen::Matrix2d brightness =
        S.bottomRightCorner<2, 2>() + 1e-9 * Eigen::Matrix2d::Identity();
    pose -= S.topRightCorner<6, 2>() * brightness.inverse() * S.topRightCorner<6, 2>().transpose();
  }
  return pose / (sigma_ * sigma_);
}

bool LevelAlignment::Solve(const NormalEquations& equations,
                           double lambda,
                           bool free_depths,
                           Vector8d* state_step,
                           std::vector<double>* rho_step) const {
  Matrix8d S = equations.H;
  Vector8d g = equations.g;
  S.diagonal() *= 1 + lambda;
  S.diagonal().array() += 1e-9;
  std::vector<double> inverse;
  if (free_depths) inverse = EliminateDepths(equations, lambda, &S, &g);
  if (!options_.affine_brightness) {
    S.rightCols<2>().setZero();
    S.bottomRows<2>().setZero();
    S.bottomRightCorner<2, 2>().setIdentity();
    g.tail<2>().setZero();
  }
  *state_step = -S.ldlt().solve(g);
  rho_step->assign(reference_.points.size(), 0);
  const size_t stride = inverse.size();
  for (size_t i = 0; free_depths && i < rho_step->size(); ++i) {
    const double* const column = equations.columns.data() + i;
    double gradient = column[8 * stride];
    for (int k = 0; k < 8; ++k) gradient += column[k * stride] * (*state_step)[k];
    (*rho_step)[i] = -gradient * inverse[i];
  }
  return state_step->allFinite();
}

int LevelAlignment::Align(bool free_depths, AlignmentState* state, std::vector<double>* rho) const {
  const AlignmentState expected = *state;
  NormalEquations equations;
  LevelCost cost = Evaluate(*state, *rho, free_depths, &equations);
  double lambda = 0.01;
  int iteration = 0;
  Vector8d step;
  std::vector<double> rho_step, rho_candidate;
  for (; iteration < options_.max_iterations && cost.visible > 0; ++iteration) {
    if (!Solve(equations, lambda, free_depths, &step, &rho_step)) break;
    const AlignmentState candidate = {SE3::Exp(step.head<6>()) * state->target_from_reference,
                                      std::clamp(state->a + step[6],
                                                 expected.a - options_.max_log_gain,
                                                 expected.a + options_.max_log_gain),
                                      std::clamp(state->b + step[7],
                                                 expected.b - options_.max_offset,
                                                 expected.b + options_.max_offset)};
    rho_candidate = *rho;
    for (size_t i = 0; i < rho_candidate.size(); ++i) {
      if (rho_step[i] != 0) rho_candidate[i] = std::max(rho_candidate[i] + rho_step[i], 1e-4);
    }
    const LevelCost candidate_cost = Evaluate(candidate, rho_candidate);
    // A step that throws points out of the image is no improvement.
    const bool better =
        candidate_cost.PerSample() < cost.PerSample() && candidate_cost.visible > cost.visible / 2;
    if (better) {
      const double gain = 1 - candidate_cost.PerSample() / cost.PerSample();
      *state = candidate;
      *rho = rho_candidate;
      lambda = std::max(lambda * 0.25, 1e-6);
      cost = Evaluate(*state, *rho, free_depths, &equations);
      if (gain < 1e-4) break;
    } else {
      if (lambda > 1e3) break;
      lambda = std::max(lambda * 8, 1e-3);
    }
  }
  return iteration;
}

}  // namespace prism
