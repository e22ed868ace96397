// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/patch_samples.h"

#include <glog/logging.h>

namespace prism {
namespace {

// Where the patch around a view begins and how it is blurred.
struct Placement {
  float x, y;  // raw px
  float blend;
  const Image<uint8_t>& colours;  // where a filter of that strength leaves good pixels
  uint8_t colour;
};

Placement Place(const PreparedRaw& raw,
                const SmoothRows& rows,
                const LensTable& lenses,
                const DefocusMatch& match,
                const LensView& view) {
  const Lens& lens = lenses.lenses()[view.lens];
  const int first = static_cast<int>(view.y - kPatchRadius);
  CHECK(rows.Holds(first, first + HalfPixelImage::kRowsTogether)) << view.y;
  const float blend = match.Blend(lens.type);
  return {view.x - kPatchRadius,
          view.y - kPatchRadius,
          blend,
          blend > 0 ? raw.lens_colour_smoother : raw.lens_colour,
          static_cast<uint8_t>(lens.colour + 1)};
}

}  // namespace

void PlaceSamples(const PreparedRaw& raw,
                  const SmoothRows& rows,
                  const LensTable& lenses,
                  const DefocusMatch& match,
                  const LensView* views,
                  int count,
                  PatchSample* samples) {
  for (int k = 0; k < count; ++k) {
    const auto [x, y, blend, colours, colour] = Place(raw, rows, lenses, match, views[k]);
    samples[k] = {rows.smooth().At(x, y),
                  blend > 0 ? rows.smoother().At(x, y) : HalfPixelImage::Cell{},
                  blend,
                  colours.row(static_cast<int>(y)) + static_cast<int>(x),
                  views[k].dx,
                  views[k].dy,
                  colour};
  }
}

void PlaceCoarseSamples(const PreparedRaw& raw,
                        const SmoothRows& rows,
                        const LensTable& lenses,
                        const DefocusMatch& match,
                        const LensView* views,
                        int count,
                        CoarseSample* samples) {
  constexpr float kQuarter = 0.5f / HalfPixelImage::kStepsPerPixel;  // to the nearest half pixel
  for (int k = 0; k < count; ++k) {
    const auto [x, y, blend, colours, colour] = Place(raw, rows, lenses, match, views[k]);
    samples[k] = {rows.smooth().Nearest(x, y),
                  blend > 0 ? rows.smoother().Nearest(x, y) : nullptr,
                  blend,
                  colours.row(static_cast<int>(y + kQuarter)) + static_cast<int>(x + kQuarter),
                  colour};
  }
}

}  // namespace prism
