// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/resample_kernel.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "prism/base/random.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

struct Sample {
  double value = 0, weight = 0;  // 0: not seen
};

// The definition in the header, one point at a time in double precision.
Sample Resample(const Lens& lens,
                const ImageF& raw,
                const Image<uint8_t>& colours,
                double radius_px,
                double X,
                double Y,
                double w,
                double sharpness) {
  const double mx = (X - lens.lens_x) * w + lens.lens_x - lens.center_x;
  const double my = (Y - lens.lens_y) * w + lens.lens_y - lens.center_y;
  const double x = lens.image_x + lens.axx * mx + lens.axy * my;
  const double y = lens.image_y + lens.ayx * mx + lens.ayy * my;
  const double squared = mx * mx + my * my;
  if (squared > radius_px * radius_px || std::min(x, y) < 1.01 || x > raw.width() - 2.01 ||
      y > raw.height() - 2.01) {
    return {};
  }
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const double fx = x - x0;
  const double fy = y - y0;
  Sample sample;
  sample.value = (1 - fy) * ((1 - fx) * raw(x0, y0) + fx * raw(x0 + 1, y0)) +
                 fy * ((1 - fx) * raw(x0, y0 + 1) + fx * raw(x0 + 1, y0 + 1));
  const bool own = colours(x0, y0) == lens.colour + 1;
  sample.weight = sharpness * std::pow(1 - squared / (radius_px * radius_px), 2) * (own ? 1 : 1e-3);
  return sample;
}

TEST(ResampleKernel, EqualsItsDefinitionPointByPoint) {
  PlenopticCamera camera = SmallCamera();
  camera.distortion.A0 = 2000;
  const LensTable table(camera);
  std::mt19937_64 generator = SeededGenerator(11, 0);
  std::uniform_real_distribution<float> gray(0, 255), depth(0.1f, 0.48f), part(0, 1);
  ImageF raw(table.width(), table.height(), 0);
  Image<uint8_t> colours(table.width(), table.height(), 0);
  for (size_t k = 0; k < raw.size(); ++k) {
    raw.data()[k] = gray(generator);
    // A tenth of the pixels is masked.
    colours.data()[k] = part(generator) < 0.1f ? 0 : table.colour_mask().data()[k];
  }
  const float radius = 10;
  int seen = 0, unseen = 0, masked = 0;
  for (const Lens& lens : table.lenses()) {
    VirtualPointRun run{};
    alignas(64) float sharpness[kResampleLanes];
    alignas(64) float sum[kResampleLanes];
    alignas(64) float weight[kResampleLanes];
    // From the left rim of the micro image over the right one.
    const float w0 = depth(generator);
    const float Y =
        lens.lens_y + (lens.center_y - lens.lens_y + 14 * (part(generator) - 0.5f)) / w0;
    for (int i = 0; i < kResampleLanes; ++i) {
      run.w[i] = w0 + 0.002f * part(generator);
      const float m = 3.2f * (static_cast<float>(i) - 3.5f) + part(generator);
      run.X[i] = lens.lens_x + (lens.center_x - lens.lens_x + m) / w0;
      run.Y[i] = Y + part(generator);
      sharpness[i] = 0.5f + part(generator);
      sum[i] = 3;
      weight[i] = 2;
    }
    ResampleLens(lens, raw, colours, radius, run, sharpness, sum, weight);
    for (int i = 0; i < kResampleLanes; ++i) {
      const Sample expected =
          Resample(lens, raw, colours, radius, run.X[i], run.Y[i], run.w[i], sharpness[i]);
      if (expected.weight == 0) {
        EXPECT_EQ(weight[i], 2) << "lens " << lens.i << ", " << lens.j << ", point " << i;
        EXPECT_EQ(sum[i], 3);
        ++unseen;
        continue;
      }
      // At the rim the kernel keeps a weight of some 1e-6.
      EXPECT_NEAR(weight[i] - 2, expected.weight, 0.0025 * sharpness[i])
          << "lens " << lens.i << ", " << lens.j << ", point " << i;
      EXPECT_NEAR(sum[i] - 3, (weight[i] - 2) * expected.value, 0.01)
          << "lens " << lens.i << ", " << lens.j << ", point " << i;
      ++seen;
      masked += expected.weight < 1e-3 * sharpness[i];
    }
  }
  EXPECT_GT(seen, 500);
  EXPECT_GT(unseen, 200);
  EXPECT_GT(masked, 20);
}

}  // namespace
}  // namespace prism
