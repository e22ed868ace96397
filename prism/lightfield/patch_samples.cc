// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/patch_samples.h"

namespace prism {
namespace {

// Where a filter of the given strength leaves good pixels.
const ImageF& ColoursFor(const PreparedRaw& raw, float blend) {
  return blend > 0 ? raw.lens_colour_smoother : raw.lens_colour;
}

}  // namespace

void PlaceSamples(const PreparedRaw& raw,
                  const LensTable& lenses,
                  const DefocusMatch& match,
                  const LensView* views,
                  int count,
                  PatchSample* samples) {
  for (int k = 0; k < count; ++k) {
    const LensView& view = views[k];
    const Lens& lens = lenses.lenses()[view.lens];
    const float x = view.x - kPatchRadius;
    const float y = view.y - kPatchRadius;
    const float blend = match.Blend(lens.type);
    samples[k] = {raw.smooth.At(x, y),
                  blend > 0 ? raw.smoother.At(x, y) : HalfPixelImage::Cell{},
                  blend,
                  ColoursFor(raw, blend).row(static_cast<int>(y)) + static_cast<int>(x),
                  view.dx,
                  view.dy,
                  static_cast<float>(lens.colour + 1)};
  }
}

void PlaceCoarseSamples(const PreparedRaw& raw,
                        const LensTable& lenses,
                        const DefocusMatch& match,
                        const LensView* views,
                        int count,
                        CoarseSample* samples) {
  constexpr float kQuarter = 0.5f / HalfPixelImage::kStepsPerPixel;  // to the nearest half pixel
  for (int k = 0; k < count; ++k) {
    const LensView& view = views[k];
    const Lens& lens = lenses.lenses()[view.lens];
    const float x = view.x - kPatchRadius;
    const float y = view.y - kPatchRadius;
    const float blend = match.Blend(lens.type);
    const ImageF& colours = ColoursFor(raw, blend);
    samples[k] = {raw.smooth.Nearest(x, y),
                  blend > 0 ? raw.smoother.Nearest(x, y) : nullptr,
                  blend,
                  colours.row(static_cast<int>(y + kQuarter)) + static_cast<int>(x + kQuarter),
                  static_cast<float>(lens.colour + 1)};
  }
}

}  // namespace prism
