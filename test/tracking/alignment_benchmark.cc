// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// Aligning one frame of 640 x 480 px to 2000 points, and what is done once a frame or keyframe for
// it.
#include <benchmark/benchmark.h>

#include "prism/tracking/frame_alignment.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

struct Scene {
  PlenopticCamera camera = SyntheticCamera({});
  ImagePyramid reference_image;
  ImagePyramid target_image;
  std::vector<ReferencePoint> points;
  TrackingReference reference;

  Scene() {
    const PlenopticProjection projection(camera);
    const SE3 motion = SE3::Exp((Vector6d() << 0.02, 0.01, 0, 0, 0.01, 0).finished());
    reference_image = RenderPlane(projection, SE3(), 0, nullptr)->image;
    target_image = RenderPlane(projection, motion, 0, nullptr)->image;
    constexpr int kStep_px = 12;  // some 2000 points
    for (int y = kStep_px; y < projection.height - kStep_px; y += kStep_px) {
      for (int x = kStep_px; x < projection.width - kStep_px; x += kStep_px) {
        Eigen::Vector3d p;
        const Eigen::Vector2d px(x, y);
        const double rho = 1 / PlaneDepth(projection, SE3(), px, &p);
        points.push_back({px, rho, 0.05 * rho});
      }
    }
    reference = MakeTrackingReference(camera, reference_image, points);
  }
};

const Scene& TheScene() {
  static const Scene scene;
  return scene;
}

void Pyramid(benchmark::State& state) {
  const ImageF& image = TheScene().target_image[0];
  for (auto _ : state) benchmark::DoNotOptimize(BuildPyramid(image, 6));
}

void Reference(benchmark::State& state) {
  const Scene& scene = TheScene();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        MakeTrackingReference(scene.camera, scene.reference_image, scene.points));
  }
}

void Alignment(benchmark::State& state) {
  const Scene& scene = TheScene();
  FrameAlignmentResult result;
  for (auto _ : state)
    result = AlignFrame(scene.reference, scene.target_image, {}, NoiseModel(), {});
  if (result.status != AlignmentStatus::kGood) state.SkipWithError("the frame was not aligned");
  state.counters["points"] = static_cast<double>(scene.points.size());
  state.counters["iterations"] = result.iterations;
}

BENCHMARK(Pyramid)->Unit(benchmark::kMillisecond);
BENCHMARK(Reference)->Unit(benchmark::kMillisecond);
BENCHMARK(Alignment)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace prism

BENCHMARK_MAIN();
