// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/focused_image.h"

#include <algorithm>
#include <iterator>

#include <glog/logging.h>
#include <tbb/parallel_for.h>

#include "prism/lightfield/resample_kernel.h"

namespace prism {
namespace {

// How sharp a lens of the given type sees a point at w, 0.02 to 1: 1 inside the type's depth range.
float TypeSharpness(const MicroLensGrid& grid, int type, float w) {
  const float low = static_cast<float>(1 / grid.types[type].max_virtual_depth);
  const float high = static_cast<float>(1 / grid.types[type].min_virtual_depth);
  const float outside = std::max({low - w, w - high, 0.0f});
  constexpr float kFade = 0.04f;  // in 1/v; a blur of about one pixel for a pitch of 23 px
  return std::max(1 / (1 + (outside / kFade) * (outside / kFade)), 0.02f);
}

}  // namespace

void RenderFocusedImage(const PlenopticCamera& camera,
                        const LensTable& lenses,
                        const ImageF& raw,
                        const Image<uint8_t>& lens_colour,
                        const ImageF& dense_inverse_virtual_depth,
                        ImageF* image) {
  const int width = camera.focused_width();
  const int height = camera.focused_height();
  CHECK_EQ(dense_inverse_virtual_depth.width(), width);
  CHECK_EQ(dense_inverse_virtual_depth.height(), height);
  if (image->width() != width || image->height() != height) *image = ImageF(width, height);
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  const float scale = static_cast<float>(camera.focused_scale);
  const float radius = lenses.radius_px();
  const int types = lenses.HasSeveralFocalLengths() ? static_cast<int>(grid.types.size()) : 1;
  tbb::parallel_for(0, height, [&](int y) {
    constexpr int kMaxLenses = 64;
    constexpr int kMaxTypes = 3;
    int around[kMaxLenses];
    alignas(64) float sharpness[kMaxTypes][kResampleLanes];
    VirtualPointRun run;
    float last = 0;
    for (int start = 0; start < width; start += kResampleLanes) {
      float lowest = 1, highest = 0;
      for (int i = 0; i < kResampleLanes; ++i) {
        const int x = std::min(start + i, width - 1);
        const float w = dense_inverse_virtual_depth(x, y);
        const Eigen::Vector2f focused_px(static_cast<float>(x), static_cast<float>(y));
        const Eigen::Vector2f point =
            lenses.VirtualPoint((focused_px.array() + 0.5f) * scale - 0.5f, w);
        run.X[i] = point.x();
        run.Y[i] = point.y();
        run.w[i] = lenses.Magnification(w);
        lowest = std::min(lowest, w);
        highest = std::max(highest, w);
        for (int type = 0; type < types; ++type) {
          sharpness[type][i] = types == 1 ? 1.0f : TypeSharpness(grid, type, w);
        }
      }
      const auto [left, right] = std::minmax_element(std::begin(run.X), std::end(run.X));
      const auto [top, bottom] = std::minmax_element(std::begin(run.Y), std::end(run.Y));
      const int count = lenses.LensesAround(
          *left, *right, *top, *bottom, lowest, highest, radius, kMaxLenses, around);
      alignas(64) float sum[kResampleLanes] = {};
      alignas(64) float weight[kResampleLanes] = {};
      for (int k = 0; k < count; ++k) {
        const Lens& lens = lenses.lenses()[around[k]];
        ResampleLens(lens,
                     raw,
                     lens_colour,
                     radius,
                     run,
                     sharpness[types == 1 ? 0 : lens.type],
                     sum,
                     weight);
      }
      for (int i = 0; i < std::min(kResampleLanes, width - start); ++i) {
        if (weight[i] > 0) last = sum[i] / weight[i];
        (*image)(start + i, y) = last;
      }
    }
  });
}

}  // namespace prism
