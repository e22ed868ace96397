// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"

namespace prism {

// An image smoothed and sampled at every half pixel: row(j, i, y)[x] is its value at
// (x + i / 2, y + j / 2). Bilinear interpolation between neighbours half a pixel apart keeps nearly
// the same sharpness at all positions. Between neighbours a pixel apart it would lose contrast in
// the middle between them: two images of a texture of 4 px then match best where both lie alike on
// the pixels, at a displacement of whole pixels instead of the true one.
//
// It takes 16 bytes a pixel, too much of a large sensor to have it of all rows at once: it may hold
// some of them, a window that moves down the image. Row y lies at y modulo the number of rows that
// are held; so that from any row on kRowsTogether follow each other, the first of these places are
// there again behind the last.
class HalfPixelImage {
 public:
  static constexpr int kStepsPerPixel = 2;
  static constexpr int kRowsTogether = 8;

  HalfPixelImage() = default;
  // With room for all rows, or for `rows` of them. Holds none.
  HalfPixelImage(int width, int height) : HalfPixelImage(width, height, height) {}
  HalfPixelImage(int width, int height, int rows);

  int width() const { return phase_[0][0].width(); }
  int height() const { return height_; }
  int room() const { return room_; }  // rows
  int begin() const { return begin_; }
  int end() const { return end_; }  // rows begin to end - 1 are held
  // Drops all rows; the next one taken is `first`.
  void Restart(int first);
  // Makes room for rows up to end - 1, to be filled, and drops the first ones for it.
  void Extend(int end);

  float* row(int j, int i, int y) { return phase_[j][i].row(PlaceOf(y)); }
  const float* row(int j, int i, int y) const { return phase_[j][i].row(PlaceOf(y)); }
  // To be called when a row has been filled.
  void Repeat(int y);

  // The four neighbours of a position and where between them it lies, in half pixels, [0, 1).
  struct Cell {
    const float* corner[4];  // (0, 0), (1, 0), (0, 1), (1, 1); pixels follow each other
    float fx, fy;
  };
  // Precondition: x and y are at least 0 and a pixel inside the right and lower edges, and the rows
  // are held.
  Cell At(float x, float y) const;
  // The value at the half pixel nearest to such a position; the values a pixel to the right follow.
  const float* Nearest(float x, float y) const {
    constexpr unsigned kSteps = kStepsPerPixel;
    const unsigned column = static_cast<unsigned>(kSteps * x + 0.5f);
    const unsigned half_row = static_cast<unsigned>(kSteps * y + 0.5f);
    return phase_[half_row % kSteps][column % kSteps].row(
               PlaceOf(static_cast<int>(half_row / kSteps))) +
           column / kSteps;
  }

 private:
  int PlaceOf(int y) const {
    const int place = y - origin_;
    return place < room_ ? place : place - room_;
  }

  ImageF phase_[kStepsPerPixel][kStepsPerPixel];
  int height_ = 0, room_ = 0;
  int begin_ = 0, end_ = 0;
  int origin_ = 0;  // the multiple of room_ at or before begin_
};

// The filters (1 2 1) / 4 at whole and (1 7 7 1) / 16 at half pixels, in x and in y, which have the
// same second moment of 1/2 px^2 and nearly the same frequency response. At the edge of the image
// the nearest pixels are repeated.
HalfPixelImage FilterHalfPixels(const ImageF& image);

// Extends `filtered`, which has the image's size, to row end - 1.
void FilterHalfPixels(const ImageF& image, int end, HalfPixelImage* filtered);

// The values at whole pixels alone: of rows begin to end - 1, or of all.
void FilterWholePixels(const ImageF& image, int begin, int end, float* filtered);
ImageF FilterWholePixels(const ImageF& image);

}  // namespace prism
