// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/geometry/se3.h"

#include <cmath>

#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include "prism/base/random.h"
#include "test/geometry/random_se3.h"

namespace prism {
namespace {

Eigen::Matrix4d AsMatrix(const SE3& T) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = T.RotationMatrix();
  matrix.topRightCorner<3, 1>() = T.translation();
  return matrix;
}

Eigen::Matrix4d Hat(const Vector6d& tangent) {
  Eigen::Matrix4d hat = Eigen::Matrix4d::Zero();  // Eq. (48) with the last row of the errata
  hat.topLeftCorner<3, 3>() = Skew(tangent.tail<3>());
  hat.topRightCorner<3, 1>() = tangent.head<3>();
  return hat;
}

TEST(SE3, ExpEqualsTheMatrixExponential) {
  std::mt19937_64 generator = SeededGenerator(1, 0);
  for (const double magnitude : {1e-9, 1e-5, 1e-3, 0.1, 1.0, 3.0}) {
    const Vector6d tangent = magnitude * RandomTangent(&generator);
    const Eigen::Matrix4d expected = Hat(tangent).exp();
    EXPECT_LT((AsMatrix(SE3::Exp(tangent)) - expected).norm(), 1e-13) << tangent.transpose();
  }
}

TEST(SE3, LogInvertsExpUpToRotationsOfPi) {
  std::mt19937_64 generator = SeededGenerator(2, 0);
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-4, 0.5, 2.0, 3.1, M_PI - 1e-6}) {
    Vector6d tangent = RandomTangent(&generator);
    tangent.tail<3>() *= angle / tangent.tail<3>().norm();
    EXPECT_LT((SE3::Exp(tangent).Log() - tangent).norm(), 1e-9) << "angle " << angle;
  }
}

TEST(SE3, GroupLawsHold) {
  std::mt19937_64 generator = SeededGenerator(3, 0);
  for (int i = 0; i < 100; ++i) {
    const SE3 a = RandomSE3(&generator), b = RandomSE3(&generator);
    EXPECT_LT((AsMatrix(a * b) - AsMatrix(a) * AsMatrix(b)).norm(), 1e-13);
    EXPECT_LT((AsMatrix(a * a.Inverse()) - Eigen::Matrix4d::Identity()).norm(), 1e-13);
    const Eigen::Vector3d p(0.3, -2, 5);
    EXPECT_LT((a * b * p - a * (b * p)).norm(), 1e-13);
  }
}

TEST(SE3, AdjointMovesAnIncrementToTheLeft) {
  std::mt19937_64 generator = SeededGenerator(4, 0);
  for (int i = 0; i < 100; ++i) {
    const SE3 T = RandomSE3(&generator);
    const Vector6d delta = RandomTangent(&generator);
    const SE3 right = T * SE3::Exp(delta);
    const SE3 left = SE3::Exp(T.Adjoint() * delta) * T;
    EXPECT_LT((AsMatrix(right) - AsMatrix(left)).norm(), 1e-12);
  }
}

TEST(SE3, TangentOrderIsTranslationThenRotationAppliedOnTheLeft) {
  const SE3 T(Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {1, 2, 3});
  Vector6d shift = Vector6d::Zero();
  shift(0) = 0.5;
  EXPECT_LT(((SE3::Exp(shift) * T).translation() - Eigen::Vector3d(1.5, 2, 3)).norm(), 1e-15);
}

}  // namespace
}  // namespace prism
