// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/level_alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace prism {

// Of half the energy, over [pose; a; b] and the inverse depth of each point.
struct LevelAlignment::NormalEquations {
  struct PointPart {
    Vector8d H_state = Vector8d::Zero();
    double H = 0;
    double g = 0;
  };
  Matrix8d H = Matrix8d::Zero();
  Vector8d g = Vector8d::Zero();
  std::vector<PointPart> points;
};

LevelAlignment::LevelAlignment(const TrackingReference& reference,
                               const ImageViewF& target_image,
                               int level,
                               const NoiseModel& noise,
                               const LevelAlignmentOptions& options,
                               double widening,
                               const PosePrior* prior)
    : reference_(reference),
      samples_(reference.levels[level]),
      camera_(reference.cameras[level]),
      image_(target_image),
      options_(options),
      prior_(prior),
      sigma_(noise.FitSigma()),
      huber_threshold_(options.huber * sigma_),
      outlier_threshold_(widening * options.outlier * sigma_) {}

double LevelAlignment::RobustSquare(double magnitude) const {
  const double huber = huber_threshold_;
  if (!options_.robust || magnitude <= huber) return magnitude * magnitude;
  return huber * (2 * magnitude - huber);
}

LevelCost LevelAlignment::Evaluate(const AlignmentState& state) const {
  std::vector<double> rho;
  for (const ReferencePoint& point : reference_.points) rho.push_back(point.rho);
  return Evaluate(state, rho, nullptr);
}

LevelCost LevelAlignment::Evaluate(const AlignmentState& state,
                                   const std::vector<double>& rho) const {
  return Evaluate(state, rho, nullptr);
}

LevelCost LevelAlignment::Evaluate(const AlignmentState& state,
                                   const std::vector<double>& rho,
                                   NormalEquations* equations) const {
  if (equations != nullptr) {
    equations->H.setZero();
    equations->g.setZero();
    equations->points.assign(reference_.points.size(), {});
  }
  LevelCost cost;
  const RelativeState relative{state.target_from_reference, std::exp(state.a), state.b};
  const ScaledProjection projection(camera_);
  PixelResidual residual;
  for (const TrackingReference::Sample& sample : samples_) {
    if (reference_.points[sample.point].is_excluded || !EvaluatePixel(sample.pixel,
                                                                      rho[sample.point],
                                                                      relative,
                                                                      projection,
                                                                      camera_.f,
                                                                      image_,
                                                                      equations != nullptr,
                                                                      &residual)) {
      continue;
    }
    ++cost.visible;
    const double r = residual.value;
    const double magnitude = std::abs(r);
    if (magnitude > outlier_threshold_) {
      cost.energy += sample.pixel.weight * RobustSquare(outlier_threshold_);
      continue;
    }
    ++cost.inliers;
    cost.energy += sample.pixel.weight * RobustSquare(magnitude);
    if (equations == nullptr) continue;
    const double weight = options_.robust && magnitude > huber_threshold_
                              ? sample.pixel.weight * huber_threshold_ / magnitude
                              : sample.pixel.weight;
    const Vector8d& J = residual.J_state;
    const Vector8d weighted = weight * J;
    // Upper triangle only.
    for (int row = 0; row < 8; ++row) {
      for (int column = row; column < 8; ++column) {
        equations->H(row, column) += weighted[row] * J[column];
      }
    }
    equations->g += weighted * r;
    NormalEquations::PointPart& point = equations->points[sample.point];
    point.H_state += weighted * residual.J_rho;
    point.H += weight * residual.J_rho * residual.J_rho;
    point.g += weight * residual.J_rho * r;
  }
  // The priors of the depths, in the unit of the residuals.
  for (size_t i = 0; i < rho.size(); ++i) {
    const ReferencePoint& point = reference_.points[i];
    if (!(point.rho_sigma > 0) || point.is_excluded) continue;
    const double root = sigma_ / point.rho_sigma;
    const double r = root * (rho[i] - point.rho);
    const double huber = options_.depth_huber * sigma_;
    const bool is_linear = options_.robust && std::abs(r) > huber;
    cost.energy += is_linear ? huber * (2 * std::abs(r) - huber) : r * r;
    if (equations == nullptr) continue;
    const double weight = is_linear ? huber / std::abs(r) : 1;
    equations->points[i].H += weight * root * root;
    equations->points[i].g += weight * root * r;
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
  if (equations != nullptr) {
    equations->H.triangularView<Eigen::StrictlyLower>() = equations->H.transpose();
  }
  return cost;
}

bool LevelAlignment::IsFree(size_t point, bool free_depths) const {
  const ReferencePoint& known = reference_.points[point];
  return free_depths && known.rho_sigma > 0 && !known.is_excluded;
}

Matrix6d LevelAlignment::PoseInformation(const AlignmentState& state,
                                         const std::vector<double>& rho,
                                         bool free_depths) const {
  NormalEquations equations;
  Evaluate(state, rho, &equations);
  Matrix8d S = equations.H;
  for (size_t i = 0; i < equations.points.size(); ++i) {
    const NormalEquations::PointPart& point = equations.points[i];
    if (IsFree(i, free_depths)) S -= point.H_state * (point.H_state.transpose() / point.H);
  }
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
  for (size_t i = 0; i < equations.points.size(); ++i) {
    const NormalEquations::PointPart& point = equations.points[i];
    if (!IsFree(i, free_depths)) continue;
    const double inverse = 1 / ((1 + lambda) * point.H);
    S.noalias() -= (inverse * point.H_state) * point.H_state.transpose();
    g -= (inverse * point.g) * point.H_state;
  }
  if (!options_.affine_brightness) {
    S.rightCols<2>().setZero();
    S.bottomRows<2>().setZero();
    S.bottomRightCorner<2, 2>().setIdentity();
    g.tail<2>().setZero();
  }
  *state_step = -S.ldlt().solve(g);
  rho_step->assign(equations.points.size(), 0);
  for (size_t i = 0; i < equations.points.size(); ++i) {
    const NormalEquations::PointPart& point = equations.points[i];
    if (!IsFree(i, free_depths)) continue;
    (*rho_step)[i] = -(point.g + point.H_state.dot(*state_step)) / ((1 + lambda) * point.H);
  }
  return state_step->allFinite();
}

int LevelAlignment::Align(bool free_depths, AlignmentState* state, std::vector<double>* rho) const {
  const AlignmentState expected = *state;
  NormalEquations equations;
  LevelCost cost = Evaluate(*state, *rho, &equations);
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
    const LevelCost candidate_cost = Evaluate(candidate, rho_candidate, nullptr);
    // A step that throws points out of the image is no improvement.
    const bool better =
        candidate_cost.PerSample() < cost.PerSample() && candidate_cost.visible > cost.visible / 2;
    if (better) {
      const double gain = 1 - candidate_cost.PerSample() / cost.PerSample();
      *state = candidate;
      *rho = rho_candidate;
      lambda = std::max(lambda * 0.25, 1e-6);
      cost = Evaluate(*state, *rho, &equations);
      if (gain < 1e-4) break;
    } else {
      if (lambda > 1e3) break;
      lambda = std::max(lambda * 8, 1e-3);
    }
  }
  return iteration;
}

}  // namespace prism
