// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
//
// The stages of the light-field front end on a synthetic 1024 x 1024 raw frame.
#include <benchmark/benchmark.h>

#include "prism/lightfield/focused_image.h"
#include "prism/lightfield/light_field_processor.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

struct Scene {
  PlenopticCamera camera = SmallCamera(1024);
  LensTable lenses{camera};
  cv::Mat raw = RenderPlane(camera, 0.3, WavyTexture, 2);
  RawPreparation preparation{lenses, cv::Mat(), PreparationOptions{}};
  PreparedRaw prepared;
  Scene() { preparation.Prepare(raw, &prepared); }
};

Scene& TheScene() {
  static Scene scene;
  return scene;
}

void Preparation(benchmark::State& state) {
  Scene& scene = TheScene();
  for (auto _ : state) scene.preparation.Prepare(scene.raw, &scene.prepared);
}

void Depth(benchmark::State& state) {
  Scene& scene = TheScene();
  DepthEstimator estimator(scene.camera, scene.lenses, DepthOptions{});
  ImageF depth(512, 512), sigma(512, 512);
  for (auto _ : state) estimator.Estimate(scene.prepared, &depth, &sigma);
}

void FillGaps(benchmark::State& state) {
  ImageF depth(512, 512, 0), sigma(512, 512, 0), dense;
  for (size_t i = 0; i < depth.size(); i += 7) {
    depth.data()[i] = 0.3f;
    sigma.data()[i] = 0.004f;
  }
  DenseDepth fill;
  for (auto _ : state) fill.Fill(depth, sigma, 0.4f, &dense);
}

void FocusedImage(benchmark::State& state) {
  Scene& scene = TheScene();
  const ImageF dense(512, 512, 0.3f);
  ImageF image;
  for (auto _ : state) {
    RenderFocusedImage(
        scene.camera, scene.lenses, scene.prepared.gray, scene.prepared.lens_colour, dense, &image);
  }
}

BENCHMARK(Preparation)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(Depth)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(FillGaps)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK(FocusedImage)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace
}  // namespace prism

BENCHMARK_MAIN();
