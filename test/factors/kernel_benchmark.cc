// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// The kernels of the estimator, each alone: interpolation, projection and the three residuals,
// these once without and once with Jacobians (the argument).
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "prism/base/random.h"
#include "prism/camera/projection.h"
#include "prism/factors/frame_manifold.h"
#include "prism/factors/frame_pair.h"
#include "prism/factors/inverse_virtual_depth_term.h"
#include "prism/factors/photometric.h"
#include "prism/image/interpolation.h"
#include "prism/solver/linear_prior.h"

namespace prism {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr size_t kCount = 1024;  // places gone through in turn, so that none stays in a register

PlenopticProjection Camera() {
  PlenopticCamera lens;
  lens.focal_length = 16.748e-3;
  lens.main_lens_mla_distance = 15.893e-3;
  lens.sensor_mla_distance = 0.376e-3;
  return PlenopticProjection(
      PlenopticFromPinhole({kWidth, kHeight, 525, 525, 0.5 * kWidth, 0.5 * kHeight}, lens));
}

ImageF WavyImage() {
  ImageF image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image(x, y) = static_cast<float>(128 + 60 * std::sin(0.11 * x) * std::cos(0.07 * y));
    }
  }
  return image;
}

// Pixels so far from the border that they stay inside the other frame.
std::vector<Eigen::Vector2d> Pixels() {
  std::mt19937_64 generator = SeededGenerator(1, 0);
  std::uniform_real_distribution<double> x(60, kWidth - 60), y(60, kHeight - 60);
  std::vector<Eigen::Vector2d> pixels;
  for (size_t i = 0; i < kCount; ++i) {
    const double column = x(generator);
    pixels.emplace_back(column, y(generator));
  }
  return pixels;
}

SE3 SmallMotion() {
  return SE3::Exp((Vector6d() << 0.02, -0.01, 0.01, 0.005, 0.01, -0.005).finished());
}

void Interpolation(benchmark::State& state) {
  const ImageF image = WavyImage();
  const ImageViewF view(image);
  const std::vector<Eigen::Vector2d> pixels = Pixels();
  size_t i = 0;
  for (auto _ : state) {
    const Eigen::Vector2d& px = pixels[i++ % kCount];
    benchmark::DoNotOptimize(InterpolateBilinear(view, px.x(), px.y()));
  }
}

void Projection(benchmark::State& state) {
  const PlenopticProjection camera = Camera();
  const SE3 target_from_host = SmallMotion();
  const std::vector<Eigen::Vector2d> pixels = Pixels();
  const RigidMotion motion(target_from_host);
  const ScaledProjection projection(camera);
  const bool with_jacobians = state.range(0) != 0;
  size_t i = 0;
  for (auto _ : state) {
    const Eigen::Vector3d X =
        motion.R * ScaledRay(camera, pixels[i++ % kCount], 0.5) + 0.5 * motion.t;
    ScaledProjection::Pixel pixel;
    projection.Project(X, 0.5, &pixel);
    benchmark::DoNotOptimize(pixel);
    if (!with_jacobians) continue;
    const Eigen::Vector3d over_X = ScaledProjection::PullBack(pixel, X, 1, 2);
    benchmark::DoNotOptimize(ScaledProjection::OverPose(over_X, X, 0.5).eval());
    benchmark::DoNotOptimize(projection.OverInverseDepth(over_X, motion.t));
  }
}

// Both frames' states, the inverse depth and room for residuals and Jacobians, as Ceres has them.
struct PhotometricBlocks {
  FrameState host;
  FrameState target{SmallMotion(), 0.02, 1.5};
  double rho = 0.5;
  std::array<double, 8> residuals{};
  std::array<double, 72> J_host{}, J_target{};
  std::array<double, 8> J_rho{};
};

void Photometric(benchmark::State& state) {
  const PlenopticProjection camera = Camera();
  const ImageF image = WavyImage();
  PhotometricBlocks blocks;
  FramePair pair;
  pair.Update(blocks.host, blocks.target);
  std::vector<PhotometricPatch> patches(kCount);
  const std::vector<Eigen::Vector2d> pixels = Pixels();
  std::deque<PhotometricCost> costs;  // a cost cannot be moved
  for (size_t i = 0; i < kCount; ++i) {
    MakePatch(image, pixels[i].array().floor(), &patches[i]);
    costs.emplace_back(&patches[i], &pair, image, &camera);
  }
  const double* parameters[] = {blocks.host.data(), blocks.target.data(), &blocks.rho};
  double* jacobians[] = {blocks.J_host.data(), blocks.J_target.data(), blocks.J_rho.data()};
  double** const wanted = state.range(0) != 0 ? jacobians : nullptr;
  size_t i = 0;
  for (auto _ : state) {
    costs[i++ % kCount].Evaluate(parameters, blocks.residuals.data(), wanted);
    benchmark::DoNotOptimize(blocks);
  }
}

// What all photometric residuals of two frames share, computed once an evaluation.
void FramePairUpdate(benchmark::State& state) {
  const FrameState host;
  const FrameState target(SmallMotion(), 0.02, 1.5);
  FramePair pair;
  for (auto _ : state) {
    pair.Update(host, target);
    benchmark::DoNotOptimize(pair);
  }
}

void InverseVirtualDepthResidual(benchmark::State& state) {
  const PlenopticProjection camera = Camera();
  const InverseVirtualDepthCost cost(0.3, 0.004, /*offset_gain=*/0, &camera);
  double rho = 0.5, residual = 0, J = 0;
  const double* parameters[] = {&rho};
  double* jacobians[] = {&J};
  double** const wanted = state.range(0) != 0 ? jacobians : nullptr;
  for (auto _ : state) {
    benchmark::DoNotOptimize(rho);
    cost.Evaluate(parameters, &residual, wanted);
    benchmark::DoNotOptimize(residual);
    benchmark::DoNotOptimize(J);
  }
}

// The prior over the six keyframes that remain in a window of seven.
void Prior(benchmark::State& state) {
  constexpr int kFrames = 6;
  constexpr int kRows = FrameState::kTangentSize * kFrames;
  LinearPrior prior;
  prior.A = Eigen::MatrixXd::Random(kRows, kRows);
  prior.b = Eigen::VectorXd::Random(kRows);
  const FrameState origin;
  for (int i = 0; i < kFrames; ++i) {
    prior.blocks.push_back(
        {FrameStateKind(), i, Eigen::Map<const Eigen::VectorXd>(origin.data(), FrameState::kSize)});
  }
  const LinearPriorCost cost(&prior);
  std::vector<FrameState> states(kFrames, FrameState(SmallMotion(), 0.02, 1.5));
  std::vector<double> residuals(kRows), J(size_t{kFrames} * kRows * FrameState::kSize);
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (int i = 0; i < kFrames; ++i) {
    parameters.push_back(states[i].data());
    jacobians.push_back(J.data() + i * kRows * FrameState::kSize);
  }
  double** const wanted = state.range(0) != 0 ? jacobians.data() : nullptr;
  for (auto _ : state) {
    cost.Evaluate(parameters.data(), residuals.data(), wanted);
    benchmark::DoNotOptimize(residuals.data());
    benchmark::ClobberMemory();
  }
}

BENCHMARK(Interpolation);
BENCHMARK(Projection)->ArgName("jacobians")->Arg(0)->Arg(1);
BENCHMARK(Photometric)->ArgName("jacobians")->Arg(0)->Arg(1);
BENCHMARK(FramePairUpdate);
BENCHMARK(InverseVirtualDepthResidual)->ArgName("jacobians")->Arg(0)->Arg(1);
BENCHMARK(Prior)->ArgName("jacobians")->Arg(0)->Arg(1);

}  // namespace
}  // namespace prism

BENCHMARK_MAIN();
