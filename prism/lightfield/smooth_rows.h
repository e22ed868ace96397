// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/lightfield/half_pixel_image.h"

namespace prism {

// Variance added by one pass of the filter, px^2 in x and in y.
inline constexpr float kFilterVariance = 0.5f;

// Standard deviation of white noise in SmoothRows::smooth over that in the raw image.
inline constexpr float kSmoothNoise = 0.375f;

// A raw image under the filters of FilterHalfPixels, of the rows that are being looked at; and, for
// arrays of several focal lengths, under (1 2 1) x (1 2 1) / 16 once more: blending towards that
// blurs a sharp lens as defocus blurs another.
class SmoothRows {
 public:
  SmoothRows() = default;
  // For images of this size, of which up to `rows` rows are looked at at once.
  SmoothRows(int width, int height, int rows, bool is_smoothed_twice);

  int room() const { return rows_; }
  // Takes another image, which has to stay until the next one. Holds none of its rows.
  void Begin(const ImageF& raw);
  // Gives the memory of a window back until the next image; that of whole images is kept.
  void Release();
  // Makes the rows begin to end - 1, as far as they are within the image, those that are held; at
  // most room() of them. In parallel. Rows that were held already are not made again.
  void MoveTo(int begin, int end);

  bool Holds(int begin, int end) const {
    const HalfPixelImage& least = is_smoothed_twice_ ? smoother_ : smooth_;
    return begin >= least.begin() && end <= least.end();
  }

  const HalfPixelImage& smooth() const { return smooth_; }
  const HalfPixelImage& smoother() const { return smoother_; }  // if smoothed twice

 private:
  const ImageF* raw_ = nullptr;
  int width_ = 0, height_ = 0, rows_ = 0;
  bool is_smoothed_twice_ = false;
  HalfPixelImage smooth_, smoother_;
};

}  // namespace prism
