// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/patch_kernel.h"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "prism/base/random.h"

namespace prism {
namespace {

TEST(PatchKernel, VectorisedSumsEqualTheReference) {
  constexpr int kStride = 40;
  std::mt19937_64 generator = SeededGenerator(3, 0);
  std::uniform_real_distribution<float> uniform(0, 1);
  HalfPixelImage image(kStride, kStride), blurred(kStride, kStride);
  for (HalfPixelImage* filled : {&image, &blurred}) {
    filled->Extend(kStride);
    for (int y = 0; y < kStride; ++y) {
      for (const auto& [j, i] : {std::pair(0, 0), {0, 1}, {1, 0}, {1, 1}}) {
        std::generate_n(filled->row(j, i, y), kStride, [&] { return 255 * uniform(generator); });
      }
    }
  }
  std::vector<uint8_t> colours(kStride * kStride);
  for (uint8_t& colour : colours) colour = uniform(generator) < 0.8f ? 2 : 0;
  for (int count = 2; count <= 6; ++count) {
    std::vector<PatchSample> samples;
    for (int k = 0; k < count; ++k) {
      const float x = 1 + 4 * static_cast<float>(k) + uniform(generator);
      const float y = 2 + 3 * static_cast<float>(k) + uniform(generator);
      samples.push_back({image.At(x, y),
                         blurred.At(x, y),
                         k % 2 == 0 ? 0.0f : uniform(generator),
                         colours.data() + (2 + 3 * k) * kStride + 1 + 4 * k,
                         40 * uniform(generator) - 20,
                         40 * uniform(generator) - 20,
                         2});
    }
    const PatchSums sums = SumPatches(samples.data(), count, kStride);
    const PatchSums reference = SumPatchesReference(samples.data(), count, kStride);
    EXPECT_NEAR(sums.cost, reference.cost, 1e-4 * reference.cost);
    EXPECT_NEAR(sums.hessian, reference.hessian, 1e-4 * reference.hessian);
    EXPECT_NEAR(sums.gradient, reference.gradient, 1e-4 * reference.hessian);
    EXPECT_NEAR(sums.freedom, reference.freedom, 1e-4 * reference.freedom);
    EXPECT_NEAR(sums.moment_x, reference.moment_x, 1e-4 * reference.hessian);
    EXPECT_NEAR(sums.moment_y, reference.moment_y, 1e-4 * reference.hessian);
    const PatchSums costs = SumPatchCosts(samples.data(), count, kStride);
    EXPECT_FLOAT_EQ(costs.cost, sums.cost);
    EXPECT_FLOAT_EQ(costs.freedom, sums.freedom);
  }
}

TEST(PatchKernel, EqualPatchesCostNothing) {
  constexpr int kStride = 20;
  ImageF ramp(kStride, kStride);
  for (int y = 0; y < kStride; ++y) {
    for (int x = 0; x < kStride; ++x) ramp(x, y) = static_cast<float>(x);
  }
  const HalfPixelImage image = FilterHalfPixels(ramp);
  const std::vector<uint8_t> colours(kStride * kStride, 1);
  const PatchSample sample{image.At(3.25f, 3.5f), {}, 0, colours.data(), 3, 0, 1};
  PatchSample other = sample;
  other.dx = -3;
  const PatchSample samples[] = {sample, other};
  const PatchSums sums = SumPatches(samples, 2, kStride);
  EXPECT_NEAR(sums.cost, 0, 1e-3);
  EXPECT_NEAR(sums.gradient, 0, 1e-3);
  EXPECT_GT(sums.hessian, 1);
}

TEST(PatchKernel, CoarseCostsAreThoseOfEverySecondRowBroughtToAllRows) {
  constexpr int kStride = 40;
  std::mt19937_64 generator = SeededGenerator(4, 0);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> pixels(kStride * kStride), blurred(kStride * kStride);
  std::vector<uint8_t> colours(pixels.size());
  for (float& pixel : pixels) pixel = 255 * uniform(generator);
  for (float& pixel : blurred) pixel = 255 * uniform(generator);
  for (uint8_t& colour : colours) colour = uniform(generator) < 0.8f ? 3 : 0;
  for (int count = 2; count <= 5; ++count) {
    std::vector<CoarseSample> samples;
    for (int k = 0; k < count; ++k) {
      const int at = (2 + 3 * k) * kStride + 1 + 4 * k;
      const float blend = k % 2 == 0 ? 0.0f : uniform(generator);
      samples.push_back({&pixels[at], &blurred[at], blend, &colours[at], 3});
    }
    double cost = 0, freedom = 0, rows = 0, all_rows = 0;
    for (int row = 0; row <= 2 * kPatchRadius; ++row) {
      all_rows += kPatchWeights[row];
      if (row % 2 == 1) continue;
      rows += kPatchWeights[row];
      for (int column = 0; column < kPatchLanes; ++column) {
        const int p = row * kStride + column;
        double n = 0, sum = 0, squares = 0;
        for (const CoarseSample& s : samples) {
          if (s.colours[p] != s.colour) continue;
          const double value = s.image[p] + s.blend * (s.blurred[p] - s.image[p]);
          n += 1;
          sum += value;
          squares += value * value;
        }
        if (n == 0) continue;
        const double weight = kPatchWeights[row] * kPatchWeights[column];
        cost += weight * (squares - sum * sum / n);
        freedom += weight * (n - 1);
      }
    }
    const PatchSums sums = SumCoarsePatchCosts(samples.data(), count, kStride);
    EXPECT_NEAR(sums.cost, cost * all_rows / rows, 1e-3 * cost);
    EXPECT_NEAR(sums.freedom, freedom * all_rows / rows, 1e-3 * freedom);
  }
}

}  // namespace
}  // namespace prism
