// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <glog/logging.h>

namespace prism {

// A read-only look at pixels owned elsewhere: row-major, `stride` elements from row to row.
// Pixel centres are integers; (0, 0) is the centre of the top-left pixel.
template <typename T>
struct ImageView {
  const T* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  const T& operator()(int x, int y) const { return data[y * stride + x]; }
  const T* row(int y) const { return data + y * stride; }
  bool Contains(double x, double y, double border = 0) const {
    return x >= border && y >= border && x <= width - 1 - border && y <= height - 1 - border;
  }
};

// An owner of width x height pixels, row-major without padding.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T value = T{})
      : width_(width), height_(height), pixels_(static_cast<size_t>(width) * height, value) {
    CHECK_GE(width, 0);
    CHECK_GE(height, 0);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return pixels_.empty(); }
  size_t size() const { return pixels_.size(); }

  T& operator()(int x, int y) { return pixels_[static_cast<size_t>(y) * width_ + x]; }
  const T& operator()(int x, int y) const { return pixels_[static_cast<size_t>(y) * width_ + x]; }
  T* row(int y) { return pixels_.data() + static_cast<size_t>(y) * width_; }
  const T* row(int y) const { return pixels_.data() + static_cast<size_t>(y) * width_; }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }

  ImageView<T> view() const { return {pixels_.data(), width_, height_, width_}; }
  operator ImageView<T>() const { return view(); }  // NOLINT: a view is what functions take

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

using ImageF = Image<float>;
using ImageViewF = ImageView<float>;

}  // namespace prism
