// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <ceres/manifold.h>
#include <Eigen/Core>

namespace prism {

// How long a block of parameters is estimated.
enum class BlockLifetime {
  kPoint,     // as long as its point; eliminated first when the window is solved
  kKeyframe,  // as long as its keyframe, which leaves it to the marginalisation prior
  kRun,       // to the end of the run (or of the segment)
};

// Owner of blocks that belong to the run; others belong to the keyframe or point of that number.
inline constexpr int kRunOwner = -1;

// What blocks of one kind have in common.
struct BlockKind {
  std::string name;  // "frame state": one name, one kind
  int size = 0;      // doubles stored
  BlockLifetime lifetime = BlockLifetime::kRun;
  std::shared_ptr<const ceres::Manifold> manifold = nullptr;  // null: a vector space

  int TangentSize() const { return manifold ? manifold->TangentSize() : size; }
  // y [-] x, TangentSize() numbers.
  Eigen::VectorXd Minus(const double* y, const double* x) const;
  // d (x [+] delta) / d delta at 0 (size x TangentSize()), and d (y [-] x) / d y at y = x.
  using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMajorMatrix PlusJacobian(const double* x) const;
  RowMajorMatrix MinusJacobian(const double* x) const;
};

using BlockKindPtr = std::shared_ptr<const BlockKind>;

// A state beside frame states and inverse depths: an offset of a sensor, a velocity. The window
// holds those of the run and those of each keyframe; terms add them (Term::AddStates).
struct StateBlock {
  BlockKindPtr kind;
  Eigen::VectorXd value;  // kind->size numbers
  // What is known of it before any measurement: value [-] prior_mean has these standard deviations.
  // Empty: nothing.
  Eigen::VectorXd prior_mean;   // kind->size
  Eigen::VectorXd prior_sigma;  // kind->TangentSize()
  // Set once it shares the marginalisation prior: where its Jacobians are evaluated.
  std::optional<Eigen::VectorXd> first_estimate = std::nullopt;
};

}  // namespace prism
