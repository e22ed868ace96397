// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/focused_image.h"

#include <algorithm>

#include <glog/logging.h>
#include <tbb/parallel_for.h>

namespace prism {
namespace {

// Bilinear value; precondition: 0 <= x < width - 1, 0 <= y < height - 1.
float Sample(const ImageF& image, float x, float y) {
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const float* p = image.row(y0) + x0;
  const float* q = p + image.width();
  const float top = p[0] + fx * (p[1] - p[0]);
  const float bottom = q[0] + fx * (q[1] - q[0]);
  return top + fy * (bottom - top);
}

}  // namespace

float TypeSharpness(const MicroLensGrid& grid, int type, float w) {
  if (grid.types.size() == 1) return 1;
  const float low = static_cast<float>(1 / grid.types[type].max_virtual_depth);
  const float high = static_cast<float>(1 / grid.types[type].min_virtual_depth);
  const float outside = std::max({low - w, w - high, 0.0f});
  constexpr float kFade = 0.04f;  // in 1/v; a blur of about one pixel for a pitch of 23 px
  return std::max(1 / (1 + (outside / kFade) * (outside / kFade)), 0.02f);
}

void RenderFocusedImage(const PlenopticCamera& camera,
                        const LensTable& lenses,
                        const PreparedRaw& raw,
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
  tbb::parallel_for(0, height, [&](int y) {
    LensView views[LensTable::kMaxViews];
    float last = 0;
    for (int x = 0; x < width; ++x) {
      const float w = dense_inverse_virtual_depth(x, y);
      const float X = (static_cast<float>(x) + 0.5f) * scale - 0.5f;
      const float Y = (static_cast<float>(y) + 0.5f) * scale - 0.5f;
      const int count = lenses.ViewsOf(X, Y, w, radius, 1.01f, views);
      float sum = 0;
      float total = 0;
      for (int k = 0; k < count; ++k) {
        const LensView& view = views[k];
        const Lens& lens = lenses.lenses()[view.lens];
        const float colour = raw.lens_colour(static_cast<int>(view.x), static_cast<int>(view.y));
        // Masked pixels (rim, saturated) count where nothing else is seen.
        const float good = colour == static_cast<float>(lens.colour + 1) ? 1.0f : 1e-3f;
        const float relative = view.radius_px / radius;
        const float inner = 1.001f - relative * relative;
        const float weight = good * inner * inner * TypeSharpness(grid, lens.type, w);
        sum += weight * Sample(raw.gray, view.x, view.y);
        total += weight;
      }
      if (total > 0) last = sum / total;
      (*image)(x, y) = last;
    }
  });
}

}  // namespace prism
