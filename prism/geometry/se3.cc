// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/geometry/se3.h"

#include <algorithm>
#include <cmath>

namespace prism {
namespace {

// Coefficients of the left Jacobian of SO(3), V = I + a Skew(w) + b Skew(w)^2 at angle theta:
// a = (1 - cos) / theta^2, b = (theta - sin) / theta^3.
struct LeftJacobianCoefficients {
  double a, b;
};

LeftJacobianCoefficients ComputeLeftJacobianCoefficients(double theta) {
  const double theta2 = theta * theta;
  if (theta < 1e-3) {
    return {0.5 - theta2 / 24 + theta2 * theta2 / 720,
            1.0 / 6 - theta2 / 120 + theta2 * theta2 / 5040};
  }
  const double half_sine = std::sin(0.5 * theta);
  return {2 * half_sine * half_sine / theta2, (theta - std::sin(theta)) / (theta2 * theta)};
}

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& w) {
  const double half = 0.5 * w.norm();
  // sin(half) / (2 half)
  const double scale = half < 1e-4 ? 0.5 * (1 - half * half / 6) : 0.5 * std::sin(half) / half;
  return Eigen::Quaterniond(std::cos(half), scale * w.x(), scale * w.y(), scale * w.z());
}

Eigen::Vector3d LogSO3(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const double sine = q.vec().norm();
  const double cosine = sign * q.w();
  // atan2 keeps full precision near pi; the series is 2 asin(s) / s for small s.
  const double scale = sine < 1e-6 ? 2 + sine * sine / 3 : 2 * std::atan2(sine, cosine) / sine;
  return sign * scale * q.vec();
}

}  // namespace

SE3::SE3(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) {
  Eigen::Map<Eigen::Quaterniond>(params_.data()) = rotation.normalized();
  Eigen::Map<Eigen::Vector3d>(params_.data() + 4) = translation;
}

SE3::SE3(const double* params) { std::copy_n(params, 7, params_.begin()); }

SE3 SE3::Exp(const Vector6d& tangent) {
  const Eigen::Vector3d v = tangent.head<3>();
  const Eigen::Vector3d w = tangent.tail<3>();
  const auto [a, b] = ComputeLeftJacobianCoefficients(w.norm());
  const Eigen::Vector3d w_cross_v = w.cross(v);
  return SE3(ExpSO3(w), v + a * w_cross_v + b * w.cross(w_cross_v));
}

Vector6d SE3::Log() const {
  const Eigen::Vector3d w = LogSO3(rotation());
  const double theta = w.norm();
  // V^-1 = I - Skew(w) / 2 + c Skew(w)^2, c = (1 - (theta / 2) cot(theta / 2)) / theta^2.
  const double half = 0.5 * theta;
  const double c = theta < 1e-3 ? 1.0 / 12 + theta * theta / 720
                                : (1 - half * std::cos(half) / std::sin(half)) / (theta * theta);
  const Eigen::Vector3d t = translation();
  const Eigen::Vector3d w_cross_t = w.cross(t);
  Vector6d tangent;
  tangent << t - 0.5 * w_cross_t + c * w.cross(w_cross_t), w;
  return tangent;
}

SE3 SE3::Inverse() const {
  const Eigen::Quaterniond inverse = rotation().conjugate();
  return SE3(inverse, -(inverse * translation()));
}

SE3 SE3::operator*(const SE3& right) const {
  return SE3(rotation() * right.rotation(), rotation() * right.translation() + translation());
}

Eigen::Vector3d SE3::operator*(const Eigen::Vector3d& p_in_source) const {
  return rotation() * p_in_source + translation();
}

Matrix6d SE3::Adjoint() const {
  const Eigen::Matrix3d R = RotationMatrix();
  Matrix6d adjoint;
  adjoint << R, Skew(translation()) * R, Eigen::Matrix3d::Zero(), R;
  return adjoint;
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d skew;
  skew << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return skew;
}

double RotationAngle(const SE3& transform) { return transform.Log().tail<3>().norm(); }

namespace {

// d (Exp(w) q) / d w at w = 0: half the left quaternion product, rows x, y, z, w (4 x 3).
Eigen::Matrix<double, 4, 3> QuaternionPlusJacobian(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> J;
  J << q.w(), q.z(), -q.y(),  //
      -q.z(), q.w(), q.x(),   //
      q.y(), -q.x(), q.w(),   //
      -q.x(), -q.y(), -q.z();
  return 0.5 * J;
}

}  // namespace

Eigen::Matrix<double, 7, 6, Eigen::RowMajor> PlusJacobian(const SE3& transform) {
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> J;
  J.setZero();
  J.block<4, 3>(0, 3) = QuaternionPlusJacobian(transform.rotation());
  J.block<3, 3>(4, 0).setIdentity();
  J.block<3, 3>(4, 3) = -Skew(transform.translation());
  return J;
}

Eigen::Matrix<double, 6, 7, Eigen::RowMajor> MinusJacobian(const SE3& transform) {
  // The quaternion columns of PlusJacobian are orthogonal with norm 1/2, so their left inverse is
  // four times their transpose; the translation follows from t = v - Skew(t) w.
  const Eigen::Matrix<double, 3, 4> J_rotation =
      4 * QuaternionPlusJacobian(transform.rotation()).transpose();
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> J;
  J.setZero();
  J.block<3, 4>(3, 0) = J_rotation;
  J.block<3, 4>(0, 0) = Skew(transform.translation()) * J_rotation;
  J.block<3, 3>(0, 4).setIdentity();
  return J;
}

}  // namespace prism
