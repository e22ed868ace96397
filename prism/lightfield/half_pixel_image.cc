// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/half_pixel_image.h"

#include <algorithm>
#include <vector>

#include <tbb/parallel_for.h>

namespace prism {
namespace {

// A row filtered in y alone, and the pixels that its filters in x reach beyond both ends.
class FilteredColumns {
 public:
  explicit FilteredColumns(int width) : width_(width), values_(static_cast<size_t>(width) + 3) {}

  void FilterWhole(const ImageF& image, int y) {
    const float* above = image.row(std::max(y - 1, 0));
    const float* here = image.row(y);
    const float* below = image.row(std::min(y + 1, image.height() - 1));
    float* out = begin();
    for (int x = 0; x < width_; ++x) out[x] = 0.25f * (above[x] + below[x]) + 0.5f * here[x];
    RepeatEnds();
  }
  void FilterHalf(const ImageF& image, int y) {
    const float* above = image.row(std::max(y - 1, 0));
    const float* here = image.row(y);
    const float* below = image.row(std::min(y + 1, image.height() - 1));
    const float* second = image.row(std::min(y + 2, image.height() - 1));
    float* out = begin();
    for (int x = 0; x < width_; ++x) {
      out[x] = 0.0625f * (above[x] + second[x]) + 0.4375f * (here[x] + below[x]);
    }
    RepeatEnds();
  }
  // In x.
  void Whole(float* out) const {
    const float* in = values_.data() + 1;
    for (int x = 0; x < width_; ++x) out[x] = 0.25f * (in[x - 1] + in[x + 1]) + 0.5f * in[x];
  }
  void Half(float* out) const {
    const float* in = values_.data() + 1;
    for (int x = 0; x < width_; ++x) {
      out[x] = 0.0625f * (in[x - 1] + in[x + 2]) + 0.4375f * (in[x] + in[x + 1]);
    }
  }

 private:
  float* begin() { return values_.data() + 1; }
  void RepeatEnds() {
    float* row = begin();
    row[-1] = row[0];
    row[width_] = row[width_ + 1] = row[width_ - 1];
  }

  int width_;
  std::vector<float> values_;
};

constexpr int kRowsAtOnce = 16;  // share a buffer

// Calls rows(begin, end) for parts of [begin, end).
template <typename Rows>
void ForParts(int begin, int end, const Rows& rows) {
  const int parts = (end - begin + kRowsAtOnce - 1) / kRowsAtOnce;
  tbb::parallel_for(0, std::max(parts, 0), [&](int part) {
    const int first = begin + part * kRowsAtOnce;
    rows(first, std::min(first + kRowsAtOnce, end));
  });
}

}  // namespace

HalfPixelImage::HalfPixelImage(int width, int height, int rows)
    : height_(height), room_(std::min(rows, height)) {
  const int places = room_ < height ? room_ + kRowsTogether : height;
  for (auto& row : phase_) {
    for (ImageF& image : row) image = ImageF(width, places);
  }
}

void HalfPixelImage::Restart(int first) {
  begin_ = end_ = first;
  origin_ = first / room_ * room_;
}

void HalfPixelImage::Extend(int end) {
  CHECK_LE(end, height_);
  end_ = std::max(end_, end);
  begin_ = std::max(begin_, end_ - room_);
  origin_ = begin_ / room_ * room_;
}

void HalfPixelImage::Repeat(int y) {
  const int place = PlaceOf(y);
  if (room_ == height_ || place >= kRowsTogether) return;
  for (auto& row : phase_) {
    for (ImageF& image : row) std::copy_n(image.row(place), width(), image.row(room_ + place));
  }
}

HalfPixelImage::Cell HalfPixelImage::At(float x, float y) const {
  constexpr unsigned kSteps = kStepsPerPixel;
  const unsigned column = static_cast<unsigned>(kSteps * x);
  const unsigned half_row = static_cast<unsigned>(kSteps * y);
  const unsigned next_column = column + 1, next_half_row = half_row + 1;
  const ImageF* above = phase_[half_row % kSteps];
  const ImageF* below = phase_[next_half_row % kSteps];
  const int top = PlaceOf(static_cast<int>(half_row / kSteps));
  const int bottom = PlaceOf(static_cast<int>(next_half_row / kSteps));
  return {{above[column % kSteps].row(top) + column / kSteps,
           above[next_column % kSteps].row(top) + next_column / kSteps,
           below[column % kSteps].row(bottom) + column / kSteps,
           below[next_column % kSteps].row(bottom) + next_column / kSteps},
          kSteps * x - static_cast<float>(column),
          kSteps * y - static_cast<float>(half_row)};
}

HalfPixelImage FilterHalfPixels(const ImageF& image) {
  HalfPixelImage filtered(image.width(), image.height());
  FilterHalfPixels(image, image.height(), &filtered);
  return filtered;
}

void FilterHalfPixels(const ImageF& image, int end, HalfPixelImage* filtered) {
  const int begin = filtered->end();
  filtered->Extend(end);
  ForParts(std::max(begin, filtered->begin()), end, [&](int first, int last) {
    FilteredColumns columns(image.width());
    for (int y = first; y < last; ++y) {
      columns.FilterWhole(image, y);
      columns.Whole(filtered->row(0, 0, y));
      columns.Half(filtered->row(0, 1, y));
      columns.FilterHalf(image, y);
      columns.Whole(filtered->row(1, 0, y));
      columns.Half(filtered->row(1, 1, y));
      filtered->Repeat(y);
    }
  });
}

void FilterWholePixels(const ImageF& image, int begin, int end, float* filtered) {
  FilteredColumns columns(image.width());
  for (int y = begin; y < end; ++y, filtered += image.width()) {
    columns.FilterWhole(image, y);
    columns.Whole(filtered);
  }
}

ImageF FilterWholePixels(const ImageF& image) {
  ImageF filtered(image.width(), image.height());
  ForParts(0, image.height(), [&](int first, int last) {
    FilterWholePixels(image, first, last, filtered.row(first));
  });
  return filtered;
}

}  // namespace prism
