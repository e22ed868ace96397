// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/smooth_rows.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "prism/image/smoothing.h"

namespace prism {
namespace {

// Whether the rows can be reached from those that are held without going back or leaving some out.
bool Continues(const HalfPixelImage& image, int begin) {
  return begin >= image.begin() && begin <= image.end();
}

}  // namespace

SmoothRows::SmoothRows(int width, int height, int rows, bool is_smoothed_twice)
    : width_(width),
      height_(height),
      rows_(std::min(rows, height)),
      is_smoothed_twice_(is_smoothed_twice) {}

void SmoothRows::Begin(const ImageF& raw) {
  CHECK_EQ(raw.width(), width_);
  CHECK_EQ(raw.height(), height_);
  raw_ = &raw;
  // A row is smoothed again with those above and below it.
  const int around = is_smoothed_twice_ ? 2 : 0;
  if (smooth_.room() == 0) smooth_ = HalfPixelImage(width_, height_, rows_ + around);
  if (smoother_.room() == 0 && is_smoothed_twice_) {
    smoother_ = HalfPixelImage(width_, height_, rows_);
  }
  smooth_.Restart(0);
  if (is_smoothed_twice_) smoother_.Restart(0);
}

void SmoothRows::Release() {
  raw_ = nullptr;
  if (rows_ < height_) smooth_ = smoother_ = HalfPixelImage();
}

void SmoothRows::MoveTo(int begin, int end) {
  const int height = raw_->height();
  begin = std::clamp(begin, 0, height);
  end = std::clamp(end, begin, height);
  CHECK_LE(end - begin, rows_);
  const int reach = is_smoothed_twice_ ? 1 : 0;
  const int first = std::max(begin - reach, 0);
  if (!Continues(smooth_, first)) smooth_.Restart(first);
  FilterHalfPixels(*raw_, std::min(end + reach, height), &smooth_);
  if (!is_smoothed_twice_) return;
  if (!Continues(smoother_, begin)) smoother_.Restart(begin);
  const int done = smoother_.end();
  smoother_.Extend(end);
  tbb::parallel_for(done, std::max(end, done), [&](int y) {
    for (int j = 0; j < HalfPixelImage::kStepsPerPixel; ++j) {
      for (int i = 0; i < HalfPixelImage::kStepsPerPixel; ++i) {
        SmoothRow(smooth_.row(j, i, std::max(y - 1, 0)),
                  smooth_.row(j, i, y),
                  smooth_.row(j, i, std::min(y + 1, height - 1)),
                  raw_->width(),
                  smoother_.row(j, i, y));
      }
    }
    smoother_.Repeat(y);
  });
}

}  // namespace prism
