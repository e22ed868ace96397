// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace prism {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A rigid transformation x_target = R x_source + t, stored as the 7 doubles of a Ceres parameter
// block: unit quaternion (x, y, z, w), then translation in metres. Named `target_from_source`.
//
// Tangent vectors are [translation; rotation] as in supplement Eq. (27); the increment is applied
// on the left, T <- Exp(delta) T (Eqs. (49)-(52)).
class SE3 {
 public:
  SE3() : params_{0, 0, 0, 1, 0, 0, 0} {}
  // The quaternion is normalised.
  SE3(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation);
  explicit SE3(const double* params);

  // Exponential and logarithm of SE(3) (Eq. (49)), exact for all rotations below pi.
  static SE3 Exp(const Vector6d& tangent);
  Vector6d Log() const;

  Eigen::Quaterniond rotation() const { return Eigen::Quaterniond(params_.data()); }
  Eigen::Vector3d translation() const { return Eigen::Vector3d(params_.data() + 4); }
  Eigen::Matrix3d RotationMatrix() const { return rotation().toRotationMatrix(); }

  SE3 Inverse() const;
  SE3 operator*(const SE3& right) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& p_in_source) const;

  // T Exp(delta) = Exp(Adjoint() delta) T.
  Matrix6d Adjoint() const;

  double* data() { return params_.data(); }
  const double* data() const { return params_.data(); }

 private:
  std::array<double, 7> params_;
};

// The same with its matrix at hand, for many points.
struct RigidMotion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  RigidMotion() = default;
  RigidMotion(const SE3& transform)  // NOLINT: one is as good as the other
      : R(transform.RotationMatrix()), t(transform.translation()) {}
};

// Skew-symmetric matrix: Skew(a) b = a x b.
Eigen::Matrix3d Skew(const Eigen::Vector3d& a);

// Rotation angle of a transformation in radians, in [0, pi].
double RotationAngle(const SE3& transform);

// d (Exp(delta) T) / d delta at delta = 0 over the 7 stored doubles (7 x 6), and its left inverse
// d Log(Y T^-1) / d Y at Y = T (6 x 7). A Jacobian over the tangent space is lifted to the stored
// doubles by J_ambient = J_tangent * MinusJacobian(T).
Eigen::Matrix<double, 7, 6, Eigen::RowMajor> PlusJacobian(const SE3& transform);
Eigen::Matrix<double, 6, 7, Eigen::RowMajor> MinusJacobian(const SE3& transform);

}  // namespace prism
