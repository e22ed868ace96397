// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/marginalization.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glog/logging.h>

#include "prism/residual/frame_manifold.h"
#include "prism/residual/photometric.h"
#include "prism/window/pair_table.h"

namespace prism {
namespace {

constexpr int kTangent = FrameState::kTangentSize;

double VisibleFraction(const Window& window, const Keyframe& keyframe) {
  if (keyframe.points.empty()) return 0;
  int visible = 0;
  for (const auto& point : keyframe.points) {
    visible += IsObserved(window, keyframe, *point, window.newest());
  }
  return static_cast<double>(visible) / static_cast<double>(keyframe.points.size());
}

double Distance(const Keyframe& a, const Keyframe& b) {
  return (a.state.pose() * b.state.pose().Inverse()).translation().norm();
}

// DSO's score: sqrt(d(i, newest)) * sum over j of 1 / (d(i, j) + eps).
double DistanceScore(const Window& window, size_t i) {
  double inverse_sum = 0;
  for (size_t j = 0; j + 1 < window.keyframes.size(); ++j) {
    if (i == j) continue;
    inverse_sum += 1 / (Distance(*window.keyframes[i], *window.keyframes[j]) + 1e-5);
  }
  return std::sqrt(Distance(*window.keyframes[i], window.newest())) * inverse_sum;
}

bool IsSeenByNewestTwo(const Window& window, const Keyframe& host, const Point& point) {
  const size_t size = window.keyframes.size();
  for (size_t j = size < 2 ? 0 : size - 2; j < size; ++j) {
    const Keyframe& target = *window.keyframes[j];
    if (target.id == host.id || IsObserved(window, host, point, target)) return true;
  }
  return false;
}

// Accumulates the residuals of marginalised points over the states of all frames of the window.
class PriorBuilder {
 public:
  PriorBuilder(const WindowOptions& options, const Window& window)
      : options_(options), window_(window), pairs_(window, options.first_estimate_jacobians) {
    const auto size = static_cast<Eigen::Index>(kTangent * window.keyframes.size());
    system_.H = Eigen::MatrixXd::Zero(size, size);
    system_.b = Eigen::VectorXd::Zero(size);
    shift_ = Eigen::VectorXd::Zero(size);
    const FrameManifold manifold(!options.affine_brightness);
    for (size_t i = 0; i < window.keyframes.size(); ++i) {
      const Keyframe& keyframe = *window.keyframes[i];
      plus_.emplace_back();
      manifold.PlusJacobian(keyframe.state.data(), plus_.back().data());
      // How far the state has moved from where the prior holds it.
      if (keyframe.first_estimate) {
        FrameManifold().Minus(
            keyframe.state.data(), keyframe.first_estimate->data(), shift_.data() + kTangent * i);
      }
    }
  }

  void AddPrior() {
    if (window_.prior.empty()) return;
    std::vector<int> columns;
    for (const int id : window_.prior_keyframe_ids) {
      for (size_t i = 0; i < window_.keyframes.size(); ++i) {
        if (window_.keyframes[i]->id != id) continue;
        for (int k = 0; k < kTangent; ++k) columns.push_back(static_cast<int>(kTangent * i) + k);
      }
    }
    const Eigen::MatrixXd H = window_.prior.A.transpose() * window_.prior.A;
    const Eigen::VectorXd b = window_.prior.A.transpose() * window_.prior.b;
    for (size_t i = 0; i < columns.size(); ++i) {
      system_.b(columns[i]) += b(i);
      for (size_t j = 0; j < columns.size(); ++j) system_.H(columns[i], columns[j]) += H(i, j);
    }
  }

  // Linearises all residuals of a point, eliminates its inverse depth and adds the rest. False if
  // the point has no photometric residual.
  bool AddPoint(size_t host_index, const Point& point) {
    const Keyframe& host = *window_.keyframes[host_index];
    std::vector<size_t> targets;
    for (size_t j = 0; j < window_.keyframes.size(); ++j) {
      if (j != host_index && IsObserved(window_, host, point, *window_.keyframes[j])) {
        targets.push_back(j);
      }
    }
    if (targets.empty()) return false;
    const bool has_depth = options_.depth_residual && point.w_sigma > 0;
    const auto rows = static_cast<Eigen::Index>(kPatternSize * targets.size() + has_depth);
    const Eigen::Index rho_column = system_.b.size();
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, rho_column + 1);
    Eigen::VectorXd r(rows);
    for (size_t k = 0; k < targets.size(); ++k) {
      AddObservation(
          host_index, targets[k], point, static_cast<Eigen::Index>(kPatternSize * k), &J, &r);
    }
    if (has_depth) {
      double dw_drho;
      const double w = InverseVirtualDepth(window_.camera, point.rho, &dw_drho);
      const double residual = (w - point.w_measured) / point.w_sigma;
      const double root = RootWeight(std::abs(residual), options_.depth_huber);
      J(rows - 1, rho_column) = root * dw_drho / point.w_sigma;
      r(rows - 1) = root * residual;
    }
    // Residuals as they would be with every frame at its linearisation point.
    r -= J.leftCols(rho_column) * shift_;
    const SquareRootMarginalization reduced =
        MarginalizeSquareRoot(J, r, {static_cast<int>(rho_column)});
    system_.H.selfadjointView<Eigen::Lower>().rankUpdate(reduced.J.transpose());
    system_.b += reduced.J.transpose() * reduced.r;
    return true;
  }

  LinearSystem system() const {
    LinearSystem symmetric = system_;
    symmetric.H.triangularView<Eigen::StrictlyUpper>() = system_.H.transpose();
    return symmetric;
  }

 private:
  double RootWeight(double magnitude, double huber) const {
    return options_.robust_loss && magnitude > huber ? std::sqrt(huber / magnitude) : 1;
  }

  void AddObservation(size_t host_index,
                      size_t target_index,
                      const Point& point,
                      Eigen::Index row,
                      Eigen::MatrixXd* J,
                      Eigen::VectorXd* r) const {
    const Keyframe& host = *window_.keyframes[host_index];
    const Keyframe& target = *window_.keyframes[target_index];
    const PhotometricCost cost(&point.patch,
                               &pairs_.pair(host_index, target_index),
                               target.frame->image[0],
                               &window_.camera);
    Eigen::Matrix<double, kPatternSize, FrameState::kSize, Eigen::RowMajor> J_host, J_target;
    Eigen::Matrix<double, kPatternSize, 1> residual, J_rho;
    const double* parameters[] = {host.state.data(), target.state.data(), &point.rho};
    double* jacobians[] = {J_host.data(), J_target.data(), J_rho.data()};
    cost.Evaluate(parameters, residual.data(), jacobians);
    const double root =
        RootWeight(residual.norm(), options_.photometric_huber * std::sqrt(double{kPatternSize}));
    J->block<kPatternSize, kTangent>(row, static_cast<Eigen::Index>(kTangent * host_index)) =
        root * J_host * plus_[host_index];
    J->block<kPatternSize, kTangent>(row, static_cast<Eigen::Index>(kTangent * target_index)) =
        root * J_target * plus_[target_index];
    J->block<kPatternSize, 1>(row, J->cols() - 1) = root * J_rho;
    r->segment<kPatternSize>(row) = root * residual;
  }

  const WindowOptions& options_;
  const Window& window_;
  PairTable pairs_;
  LinearSystem system_;    // lower triangle of H only
  Eigen::VectorXd shift_;  // current state [-] first estimate, 0 for frames without one
  std::vector<Eigen::Matrix<double, FrameState::kSize, kTangent, Eigen::RowMajor>> plus_;
};

RetiredPoint MakeRetiredPoint(const Window& window, const Keyframe& host, const Point& point) {
  constexpr int kCenter = 4;  // of kPattern
  return {host.id,
          UnprojectInverseDepth(window.camera, point.patch.px, point.rho),
          point.patch.intensity[kCenter]};
}

}  // namespace

std::vector<int> KeyframesToRetire(const WindowOptions& window_options,
                                   const RetirementOptions& options,
                                   const Window& window) {
  std::vector<int> ids;
  const size_t size = window.keyframes.size();
  if (size <= 3) return ids;
  for (size_t i = 0; i + 2 < size; ++i) {
    const Keyframe& keyframe = *window.keyframes[i];
    const double log_gain = std::abs(keyframe.state.a() - window.newest().state.a());
    if (size - ids.size() > 3 &&
        (VisibleFraction(window, keyframe) < options.min_visible_fraction ||
         log_gain > options.max_log_gain)) {
      ids.push_back(keyframe.id);
    }
  }
  while (static_cast<int>(size - ids.size()) > window_options.max_keyframes) {
    double best = -1;
    int best_id = -1;
    for (size_t i = 0; i + 2 < size; ++i) {
      const int id = window.keyframes[i]->id;
      if (std::find(ids.begin(), ids.end(), id) != ids.end()) continue;
      const double score = DistanceScore(window, i);
      if (score > best) {
        best = score;
        best_id = id;
      }
    }
    ids.push_back(best_id);
  }
  return ids;
}

RetirementResult RetireKeyframe(const WindowOptions& options, int keyframe_id, Window* window) {
  RetirementResult result;
  auto& keyframes = window->keyframes;
  const auto leaving = std::find_if(keyframes.begin(), keyframes.end(), [&](const auto& keyframe) {
    return keyframe->id == keyframe_id;
  });
  CHECK(leaving != keyframes.end()) << "keyframe " << keyframe_id << " is not in the window";
  const auto leaving_index = static_cast<size_t>(leaving - keyframes.begin());

  PriorBuilder builder(options, *window);
  builder.AddPrior();
  for (size_t i = 0; i < keyframes.size(); ++i) {
    Keyframe& host = *keyframes[i];
    size_t kept = 0;
    for (size_t p = 0; p < host.points.size(); ++p) {
      const Point& point = *host.points[p];
      if (i != leaving_index && IsSeenByNewestTwo(*window, host, point)) {
        if (kept != p) host.points[kept] = std::move(host.points[p]);
        ++kept;
        continue;
      }
      const bool informative = options.marginalization_prior ? builder.AddPoint(i, point) : true;
      if (informative) {
        result.points.push_back(MakeRetiredPoint(*window, host, point));
        ++result.marginalized_points;
      } else {
        ++result.dropped_points;
      }
    }
    host.points.resize(kept);
  }

  if (options.marginalization_prior) {
    std::vector<int> leaving_columns(kTangent);
    std::iota(
        leaving_columns.begin(), leaving_columns.end(), kTangent * static_cast<int>(leaving_index));
    const LinearSystem reduced = Marginalize(builder.system(), leaving_columns).system;
    const SquareRootSystem root = SquareRoot(reduced);
    result.rank = root.rank;
    window->prior = {root.A, root.r, {}};
    window->prior_keyframe_ids.clear();
  }
  keyframes.erase(leaving);
  if (options.marginalization_prior) {
    for (const auto& keyframe : keyframes) {
      if (!keyframe->first_estimate) keyframe->first_estimate = keyframe->state;
      window->prior.linearization.push_back(*keyframe->first_estimate);
      window->prior_keyframe_ids.push_back(keyframe->id);
    }
  }
  return result;
}

RetirementResult ForgetOldestKeyframe(Window* window) {
  CHECK(!window->empty());
  RetirementResult result;
  const Keyframe& oldest = *window->keyframes.front();
  for (const auto& point : oldest.points) {
    result.points.push_back(MakeRetiredPoint(*window, oldest, *point));
  }
  result.dropped_points = static_cast<int>(result.points.size());
  window->keyframes.pop_front();
  window->prior = {};
  window->prior_keyframe_ids.clear();
  return result;
}

}  // namespace prism
