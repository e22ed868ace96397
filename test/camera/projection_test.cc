// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/projection.h"

#include <string>

#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "test/camera/numeric_jacobian.h"
#include "test/geometry/random_se3.h"

namespace prism {
namespace {

PlenopticCamera Camera16mm(MicroLensMode mode = MicroLensMode::kGalilean) {
  PlenopticCamera camera;
  camera.mode = mode;
  camera.focal_length = 16.748e-3;
  camera.main_lens_mla_distance = mode == MicroLensMode::kGalilean ? 15.893e-3 : 18.064e-3;
  camera.sensor_mla_distance = 0.376e-3;
  camera.raw_width = camera.raw_height = 2048;
  camera.raw_pixel_size = 5.5e-6;
  camera.raw_principal_point = {1018.7, 1054.2};
  return camera;
}

// The camera and point of the errata's own check.
PlenopticCamera ErrataCamera() {
  PlenopticCamera camera = Camera16mm();
  camera.focal_length = 35e-3;
  camera.main_lens_mla_distance = 34.6e-3;
  camera.sensor_mla_distance = 0.35e-3;
  return camera;
}

PlenopticCamera OfChiefRays() {
  PlenopticCamera camera = Camera16mm();
  camera.focused_image = FocusedImage::kChiefRays;
  return camera;
}

class ProjectionInMode : public ::testing::TestWithParam<MicroLensMode> {};

INSTANTIATE_TEST_SUITE_P(Modes,
                         ProjectionInMode,
                         ::testing::Values(MicroLensMode::kGalilean, MicroLensMode::kKeplerian),
                         [](const auto& test) { return std::string(ToString(test.param)); });

double MixedError(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return ((a - b).array().abs() / (1 + a.array().abs().max(b.array().abs()))).maxCoeff();
}

TEST_P(ProjectionInMode, FollowsEquations2And4And10) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  const Eigen::Vector3d x_C(0.3, -0.2, 2.5);
  Eigen::Vector3d x_V;
  ASSERT_TRUE(Project(camera, x_C, &x_V));
  const double b_L = 1 / (1 / camera.f - 1 / x_C.z());
  EXPECT_NEAR(x_V.x(), x_C.x() / x_C.z() * b_L / camera.s + camera.c.x(), 1e-9);
  EXPECT_NEAR(x_V.y(), x_C.y() / x_C.z() * b_L / camera.s + camera.c.y(), 1e-9);
  const double sign = GetParam() == MicroLensMode::kKeplerian ? -1 : 1;
  EXPECT_NEAR(x_V.z(), sign * (b_L - camera.b_L0) / 0.376e-3, 1e-9);
  EXPECT_GT(x_V.z(), 2);
}

TEST_P(ProjectionInMode, FocusedImageIsAPinholeImageFromTheFrontFocalPoint) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  const Eigen::Vector3d x_C(0.3, -0.2, 1.5);
  Eigen::Vector3d x_V;
  ASSERT_TRUE(Project(camera, x_C, &x_V));
  const Eigen::Vector2d pinhole =
      camera.FocalLengthPx() * x_C.head<2>() / (x_C.z() - camera.f) + camera.c;
  EXPECT_LT((x_V.head<2>() - pinhole).norm(), 1e-9);
}

TEST_P(ProjectionInMode, UnprojectInvertsProject) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  std::mt19937_64 generator = SeededGenerator(11, 0);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const double z = 2 + 1.8 * uniform(generator);
    const Eigen::Vector3d x_C(0.4 * z * uniform(generator), 0.4 * z * uniform(generator), z);
    Eigen::Vector3d x_V;
    ASSERT_TRUE(Project(camera, x_C, &x_V));
    EXPECT_NEAR(InverseDepth(camera, 1 / x_V.z()), 1 / z, 1e-9);
    EXPECT_LT((UnprojectInverseDepth(camera, x_V.head<2>(), 1 / z) - x_C).norm(), 1e-9 * z);
  }
}

TEST(Projection, PointsAtOrInsideTheFocalLengthAreInvalid) {
  const PlenopticProjection camera(Camera16mm());
  Eigen::Vector3d x_V(-1, -1, -1);
  EXPECT_FALSE(Project(camera, {0, 0, camera.f}, &x_V));
  EXPECT_FALSE(Project(camera, {0, 0, -2}, &x_V));
  EXPECT_EQ(x_V, Eigen::Vector3d(-1, -1, -1));
  EXPECT_FALSE(ProjectBetweenFrames(camera, {500, 500}, 1 / camera.f, SE3(), &x_V));
}

TEST_P(ProjectionInMode, PyramidLevelsShareOneGeometry) {
  const PlenopticProjection level0(Camera16mm(GetParam()), 0), level2(Camera16mm(GetParam()), 2);
  Eigen::Vector3d x0, x2;
  ASSERT_TRUE(Project(level0, {0.3, -0.2, 1.5}, &x0));
  ASSERT_TRUE(Project(level2, {0.3, -0.2, 1.5}, &x2));
  EXPECT_NEAR((x2.x() + 0.5) * 4 - 0.5, x0.x(), 1e-9);
  EXPECT_NEAR((x2.y() + 0.5) * 4 - 0.5, x0.y(), 1e-9);
  EXPECT_NEAR(x2.z(), x0.z(), 1e-12);
}

TEST_P(ProjectionInMode, InverseVirtualDepthInvertsInverseDepthAndMatchesItsDerivative) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  for (const double rho : {-0.05, 0.0, 0.1, 0.5, 1.0, 3.0}) {
    double dw_drho, drho_dw;
    const double w = InverseVirtualDepth(camera, rho, &dw_drho);
    EXPECT_NEAR(InverseDepth(camera, w, &drho_dw), rho, 1e-11);
    EXPECT_NEAR(dw_drho * drho_dw, 1, 1e-11);
    const double h = 1e-5;
    EXPECT_NEAR(
        dw_drho,
        (InverseVirtualDepth(camera, rho + h) - InverseVirtualDepth(camera, rho - h)) / (2 * h),
        1e-8 * std::abs(dw_drho) + 1e-12);
  }
  EXPECT_NEAR(InverseVirtualDepth(camera, 0), InverseVirtualDepthAtInfinity(camera), 1e-15);
}

TEST_P(ProjectionInMode, InverseVirtualDepthVariancePropagatesThereAndBack) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  const double rho = 0.4;
  const double w = InverseVirtualDepth(camera, rho);
  const double rho_variance = InverseDepthVariance(camera, w, 0.004 * 0.004);
  double dw_drho;
  InverseVirtualDepth(camera, rho, &dw_drho);
  EXPECT_NEAR(dw_drho * dw_drho * rho_variance, 1.6e-5, 1e-15);
}

TEST(ProjectionJacobian, OfProjectMatchesNumericDifferences) {
  for (const PlenopticCamera& model :
       {ErrataCamera(), Camera16mm(MicroLensMode::kKeplerian), OfChiefRays()}) {
    const PlenopticProjection camera(model);
    const Eigen::Vector3d x_C(0.3, -0.2, 2.5);
    Eigen::Vector3d x_V;
    Eigen::Matrix3d J;
    ASSERT_TRUE(Project(camera, x_C, &x_V, &J));
    const auto f = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      Eigen::Vector3d out;
      EXPECT_TRUE(Project(camera, x, &out));
      return out;
    };
    EXPECT_LT(MixedError(J, NumericJacobian(f, x_C)), 1e-8);
  }
}

TEST_P(ProjectionInMode, ProjectBetweenFramesEqualsUnprojectTransformProject) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  std::mt19937_64 generator = SeededGenerator(12, 0);
  for (int i = 0; i < 100; ++i) {
    const SE3 T = SE3::Exp(0.1 * RandomTangent(&generator));
    const Eigen::Vector2d px(300 + 4 * i, 800 - 5 * i);
    Eigen::Vector3d expected, x_V;
    ASSERT_TRUE(Project(camera, T * UnprojectInverseDepth(camera, px, 0.4), &expected));
    ASSERT_TRUE(ProjectBetweenFrames(camera, px, 0.4, T, &x_V));
    EXPECT_LT((x_V - expected).norm(), 1e-8);
  }
}

TEST_P(ProjectionInMode, ProjectBetweenFramesWorksAtInfinity) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  const SE3 T = SE3::Exp((Vector6d() << 0.1, -0.2, 0.05, 0.02, 0.03, -0.01).finished());
  Eigen::Vector3d at_infinity, far;
  ASSERT_TRUE(ProjectBetweenFrames(camera, {400, 600}, 0, T, &at_infinity));
  ASSERT_TRUE(ProjectBetweenFrames(camera, {400, 600}, 1e-9, T, &far));
  EXPECT_LT((at_infinity - far).norm(), 1e-5);
}

TEST(ScaledProjection, JacobiansMatchNumericDifferences) {
  std::mt19937_64 generator = SeededGenerator(13, 0);
  const PlenopticCamera keplerian = Camera16mm(MicroLensMode::kKeplerian);
  for (const PlenopticCamera& model : {Camera16mm(), ErrataCamera(), keplerian, OfChiefRays()}) {
    const PlenopticProjection camera(model);
    const ScaledProjection projection(camera);
    for (int i = 0; i < 20; ++i) {
      const SE3 T = SE3::Exp(0.1 * RandomTangent(&generator));
      const Eigen::Vector2d px(300 + 20 * i, 800 - 25 * i);
      const double rho = 0.02 * i;         // from infinity to 2.6 m
      const Eigen::Vector2d g(0.7, -0.3);  // the function of the pixel is g . (x, y)
      const auto value = [&](const SE3& target_from_host, double r) -> Eigen::VectorXd {
        Eigen::Vector3d x_V;
        EXPECT_TRUE(ProjectBetweenFrames(camera, px, r, target_from_host, &x_V));
        return Eigen::VectorXd::Constant(1, g.dot(x_V.head<2>()));
      };
      const RigidMotion motion(T);
      const Eigen::Vector3d X = motion.R * ScaledRay(camera, px, rho) + rho * motion.t;
      ScaledProjection::Pixel pixel;
      ASSERT_TRUE(projection.Project(X, rho, &pixel));
      const Eigen::Vector3d over_X = ScaledProjection::PullBack(pixel, X, g.x(), g.y());
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(6);
      EXPECT_LT(
          MixedError(
              ScaledProjection::OverPose(over_X, X, rho).transpose(),
              NumericJacobian([&](const Eigen::VectorXd& d) { return value(SE3::Exp(d) * T, rho); },
                              zero)),
          2e-8);
      const Eigen::Vector2d m = (px - camera.c) * (camera.s / camera.f);
      const Eigen::Vector3d dX =
          motion.t - camera.center_z() * (motion.R * Eigen::Vector3d(m.x(), m.y(), 0));
      EXPECT_LT(MixedError(Eigen::MatrixXd::Constant(1, 1, projection.OverInverseDepth(over_X, dX)),
                           NumericJacobian([&](const Eigen::VectorXd& r) { return value(T, r(0)); },
                                           Eigen::VectorXd::Constant(1, rho))),
                2e-8);
    }
  }
}

TEST(ProjectionOfChiefRays, IsAPinholeImageFromTheMainLens) {
  const PlenopticProjection virtual_points(Camera16mm());
  const PlenopticProjection camera(OfChiefRays());
  for (const double z : {0.3, 1.5, 20.0}) {
    const Eigen::Vector3d x_C(0.3 * z, -0.2 * z, z);
    Eigen::Vector3d x_V, of_virtual_point;
    ASSERT_TRUE(Project(camera, x_C, &x_V));
    const Eigen::Vector2d pinhole = camera.FocalLengthPx() / z * x_C.head<2>() + camera.c;
    EXPECT_LT((x_V.head<2>() - pinhole).norm(), 1e-9);
    EXPECT_LT((UnprojectInverseDepth(camera, x_V.head<2>(), 1 / z) - x_C).norm(), 1e-9 * z);
    // Depth and what lies infinitely far are those of virtual points.
    ASSERT_TRUE(Project(virtual_points, x_C, &of_virtual_point));
    EXPECT_EQ(x_V.z(), of_virtual_point.z());
    EXPECT_NEAR((of_virtual_point.x() - camera.c.x()) / (x_V.x() - camera.c.x()),
                z / (z - camera.f),
                1e-12);
  }
  Eigen::Vector3d x_V;
  EXPECT_FALSE(Project(camera, {0, 0, camera.f}, &x_V));
  EXPECT_FALSE(ProjectBetweenFrames(camera, {500, 500}, 1 / camera.f, SE3(), &x_V));
}

TEST(ProjectBetweenFrames, TheEpipolarCurveIsAStraightLine) {
  const PlenopticProjection camera(Camera16mm());
  const SE3 T = SE3::Exp((Vector6d() << 0.1, -0.2, 0.05, 0.02, 0.03, -0.01).finished());
  Eigen::Vector3d a, b, c;
  ASSERT_TRUE(ProjectBetweenFrames(camera, {200, 900}, 0.1, T, &a));
  ASSERT_TRUE(ProjectBetweenFrames(camera, {200, 900}, 1.0, T, &b));
  ASSERT_TRUE(ProjectBetweenFrames(camera, {200, 900}, 3.0, T, &c));
  const Eigen::Vector2d ab = (b - a).head<2>(), ac = (c - a).head<2>();
  EXPECT_GT(ac.norm(), 50);
  EXPECT_LT(std::abs(ab.x() * ac.y() - ab.y() * ac.x()) / ac.norm(), 1e-9);
}

TEST(RawProjection, MicroLensCentresScaleAboutThePrincipalPoint) {
  const PlenopticCamera camera = Camera16mm();
  const Eigen::Vector2d c = camera.raw_principal_point;
  EXPECT_EQ(MicroLensCenter(camera, c), c);
  const Eigen::Vector2d c_ML = MicroLensCenter(camera, c + Eigen::Vector2d(100, 0));
  EXPECT_NEAR(c_ML.x() - c.x(), 100 * 15.893 / (15.893 + 0.376), 1e-9);
}

TEST(RawProjection, KeplerianMicroImagesAreUpsideDown) {
  const Eigen::Vector2d c_ML(500, 700);
  const Eigen::Vector3d x_V(520, 690, 4);
  EXPECT_EQ(ProjectToRaw(Camera16mm(), x_V, c_ML), Eigen::Vector2d(505, 697.5));
  EXPECT_EQ(ProjectToRaw(Camera16mm(MicroLensMode::kKeplerian), x_V, c_ML),
            Eigen::Vector2d(495, 702.5));
}

TEST(RawProjection, RawAndFocusedGridsShareTheirTopLeftCorner) {
  const PlenopticCamera camera = Camera16mm();
  EXPECT_EQ(RawFromFocused(camera, {-0.5, -0.5}), Eigen::Vector2d(-0.5, -0.5));
  EXPECT_EQ(RawFromFocused(camera, {0, 0}), Eigen::Vector2d(0.5, 0.5));
  EXPECT_EQ(FocusedFromRaw(camera, RawFromFocused(camera, {17.25, 3})), Eigen::Vector2d(17.25, 3));
}

// Eqs. (88)-(89).
Eigen::Vector2d PinholeFromVirtual(const PlenopticProjection& camera, const Eigen::Vector3d& x_V) {
  const double b_L = x_V.z() * camera.B + camera.b_L0;
  return (x_V.head<2>() - camera.c) * ((2 * camera.B + camera.b_L0) / b_L) + camera.c;
}

TEST_P(ProjectionInMode, PinholeViewVirtualFromPinholeInvertsEquations88And89) {
  const PlenopticProjection camera(Camera16mm(GetParam()));
  const double rho = 0.6;
  const Eigen::Vector2d pinhole(123.4, 700.1);
  Eigen::Vector3d x_V;
  x_V << VirtualFromPinhole(camera, pinhole, rho), 1 / InverseVirtualDepth(camera, rho);
  EXPECT_LT((PinholeFromVirtual(camera, x_V) - pinhole).norm(), 1e-9);
}

TEST_P(ProjectionInMode, PinholeViewIsACentralProjectionThroughTheMainLens) {
  const PlenopticCamera model = Camera16mm(GetParam());
  const PlenopticProjection camera(model);
  const PinholeCamera view = PinholeView(model);
  const Eigen::Vector3d x_C(0.3, -0.2, 1.5);
  Eigen::Vector3d x_V;
  ASSERT_TRUE(Project(camera, x_C, &x_V));
  const Eigen::Vector2d px = PinholeFromVirtual(camera, x_V);
  EXPECT_NEAR(px.x(), view.fx * x_C.x() / x_C.z() + view.cx, 1e-9);
  EXPECT_NEAR(px.y(), view.fy * x_C.y() / x_C.z() + view.cy, 1e-9);
}

TEST_P(ProjectionInMode, PinholeViewOfAPlenopticCameraMadeFromAPinholeIsThatPinhole) {
  const PinholeCamera pinhole{640, 480, 525, 525, 320, 240};
  const PinholeCamera view = PinholeView(PlenopticFromPinhole(pinhole, Camera16mm(GetParam())));
  EXPECT_NEAR(view.fx, 525, 1e-10);
  EXPECT_NEAR(view.cx, 320, 1e-12);
  EXPECT_NEAR(view.cy, 240, 1e-12);
}

TEST(Distortion, UndistortInvertsDistortAndJacobianMatches) {
  const Distortion distortion{-90.0, 2e4, 0.02, -0.03};
  for (const Eigen::Vector2d& x :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(4e-3, -3e-3), Eigen::Vector2d(-5.6e-3, 5.6e-3)}) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d distorted = distortion.Distort(x, &J);
    EXPECT_LT((distortion.Undistort(distorted) - x).norm(), 1e-16);
    const auto f = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
      return distortion.Distort(p);
    };
    EXPECT_LT(MixedError(J, NumericJacobian(f, x, 1e-5)), 1e-9);
  }
}

}  // namespace
}  // namespace prism
