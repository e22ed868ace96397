// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "prism/camera/plenoptic_camera.h"
#include "prism/image/image.h"

namespace prism {

// One micro lens in raw px. The micro image is the disc of LensTable::radius() around `image`.
struct Lens {
  float image_x, image_y;    // centre of the micro image on the sensor (distorted)
  float center_x, center_y;  // the same, undistorted: c_I
  float lens_x, lens_y;      // c_ML of Eq. (8)
  float axx, axy, ayx, ayy;  // Jacobian of the distortion at the centre
  int type;                  // index into MicroLensGrid::types
  int colour;                // 0, 1, 2; differs between neighbours
  int i, j;                  // on the lattice (LensIndex)
};

// A virtual point as one lens sees it.
struct LensView {
  int lens;         // index into LensTable::lenses()
  float x, y;       // raw px on the sensor
  float dx, dy;     // d(x, y) / d(1/v)
  float radius_px;  // distance from the micro-image centre
};

// Everything about the micro-lens array that does not change from frame to frame.
//
// A virtual point (X, v) in undistorted raw px is seen by the lens c_ML at
// x_R = (X - c_ML) w + c_ML, w = 1/v (Eqs. (6)-(7); -1/v in a Keplerian camera), and only if x_R
// lies in the micro image around c_I. With c_ML = k c_I (Eq. (8)) the offset from c_I vanishes at
// c_ML = X w / (w + 1/k - 1): the lenses that see the point are those near that chief ray.
// Distortion is linearised within a micro image. All functions take 1/v > 0 in either mode.
class LensTable {
 public:
  static constexpr int kMaxViews = 24;
  static constexpr unsigned kAllTypes = ~0u;

  // Precondition: the camera is valid and has a grid.
  explicit LensTable(const PlenopticCamera& camera);

  const std::vector<Lens>& lenses() const { return lenses_; }
  int width() const { return width_; }
  int height() const { return height_; }
  float radius_px() const { return radius_px_; }  // of a micro image without its dark rim
  float pitch_px() const { return pitch_px_; }
  // 1/v that each lens type is focused on.
  const std::vector<float>& focus_of_type() const { return focus_of_type_; }
  bool HasSeveralFocalLengths() const;

  // The magnification of micro images at 1/v: 1/v, or -1/v in a Keplerian camera.
  float Magnification(float inverse_virtual_depth) const { return sign_ * inverse_virtual_depth; }

  // The virtual point at 1/v that a pixel of the focused image shows, and back; undistorted raw px.
  // They are the same in images of virtual points; in those of chief rays, their distances from the
  // principal point are as b_L to f_L.
  Eigen::Vector2f VirtualPoint(const Eigen::Vector2f& pixel, float inverse_virtual_depth) const {
    if (!is_of_chief_rays_) return pixel;
    return VirtualScale(inverse_virtual_depth) * (pixel - principal_) + principal_;
  }
  Eigen::Vector2f PixelOf(const Eigen::Vector2f& virtual_point, float inverse_virtual_depth) const {
    if (!is_of_chief_rays_) return virtual_point;
    return (virtual_point - principal_) / VirtualScale(inverse_virtual_depth) + principal_;
  }

  // Variance in x and in y of the spot of a point out of focus by 1 in 1/v, px^2: a quarter of the
  // squared radius of a micro lens.
  float DefocusVariance() const;

  // Colour + 1 of the lens whose micro image holds the pixel, 0 in the gaps between them.
  const Image<uint8_t>& colour_mask() const { return colour_mask_; }

  // Calls visit(x, y) for the pixels of a lens' micro image, row by row.
  template <typename Visit>
  void ForEachPixel(const Lens& lens, const Visit& visit) const {
    ForEachPixelNear(lens, [&](int x, int y) {
      if (colour_mask_(x, y) == lens.colour + 1) visit(x, y);
    });
  }

  // Index of the lens nearest to a point on the chief-ray lattice, -1 outside the array.
  int NearestLens(float x_raw_px, float y_raw_px) const;

  // Indices of the other lenses within a baseline of at most 6 pitches, nearest first.
  std::vector<int> NeighboursOf(int lens, float max_baseline_px) const;

  // Indices of lenses among which are all that see, within `max_radius_px` of their micro-image
  // centres, a virtual point (X, Y, 1/v) with X in [X0, X1], Y in [Y0, Y1] and 1/v in [w0, w1].
  // Returns their number, at most max_count.
  int LensesAround(float X0,
                   float X1,
                   float Y0,
                   float Y1,
                   float w0,
                   float w1,
                   float max_radius_px,
                   int max_count,
                   int* lenses) const;

  // Between which rows of the raw image lie all views that ViewsOf may give of virtual points with
  // Y in [Y0, Y1] and 1/v in [w0, w1], and the longest (dx, dy) of these. Infinite around where a
  // Keplerian camera has the points in its micro lenses.
  struct RowsOfViews {
    float first, last, longest_motion;
  };
  RowsOfViews RowsAround(float Y0, float Y1, float w0, float w1, float max_radius_px) const;

  // The lenses that see the virtual point (X, Y, 1/v = w) within `max_radius_px` of their
  // micro-image centres and `margin_px` inside the image, from the chief ray outwards, at most
  // `max_count` <= kMaxViews of those whose type's bit is set in `types`. Returns their number.
  int ViewsOf(float X,
              float Y,
              float w,
              float max_radius_px,
              float margin_px,
              unsigned types,
              int max_count,
              LensView* views) const;
  int ViewsOf(
      float X, float Y, float w, float max_radius_px, float margin_px, LensView* views) const {
    return ViewsOf(X, Y, w, max_radius_px, margin_px, kAllTypes, kMaxViews, views);
  }

 private:
  struct Offset {
    int di, dj;
    float length_px;
  };
  static constexpr int kCells = 8;  // a side of the lattice cell, for lists of lenses by distance

  // b_L / f_L
  float VirtualScale(float w) const { return scale_at_array_ + scale_per_v_ / Magnification(w); }
  int IndexOf(int i, int j) const {
    if (i < min_i_ || j < min_j_ || i >= min_i_ + size_i_ || j >= min_j_ + size_j_) return -1;
    return index_[static_cast<size_t>(j - min_j_) * size_i_ + (i - min_i_)];
  }
  // Where a chief ray meets the lattice of micro-image centres, undistorted raw px.
  Eigen::Vector2f ChiefRay(float X, float Y, float w) const;
  // Distance from the chief ray at which lenses see a point at max_radius_px from their centre.
  float Reach(float w, float max_radius_px) const;
  // Lenses around a point of that lattice by distance from it; i and j are its cell's.
  const std::vector<Offset>& OffsetsAround(const Eigen::Vector2f& chief, int* i, int* j) const;
  float cell_radius_px() const { return 0.87f / kCells * pitch_px_ + 1; }  // and 1 px of distortion
  void BuildColourMask();
  // The pixels of the square around a micro image.
  template <typename Visit>
  void ForEachPixelNear(const Lens& lens, const Visit& visit) const {
    const int reach = static_cast<int>(std::ceil(radius_px_));
    const int x0 = static_cast<int>(std::lround(lens.image_x));
    const int y0 = static_cast<int>(std::lround(lens.image_y));
    for (int y = std::max(y0 - reach, 0); y <= std::min(y0 + reach, height_ - 1); ++y) {
      for (int x = std::max(x0 - reach, 0); x <= std::min(x0 + reach, width_ - 1); ++x) {
        visit(x, y);
      }
    }
  }

  int width_, height_;
  float radius_px_, pitch_px_;
  float sign_;  // PlenopticCamera::virtual_depth_sign
  std::vector<float> focus_of_type_;
  Eigen::Vector2f principal_;
  float stretch_ = 0, shift_px_ = 0;    // the most by which lenses' distortions stretch, and the
                                        // longest from c_I to c_ML
  float eq8_scale_;                     // k: c_ML - c = k (c_I - c)
  bool is_of_chief_rays_;               // PlenopticCamera::focused_image
  float scale_at_array_, scale_per_v_;  // of b_L / f_L = (b_L0 + sign v B) / f_L
  Eigen::Vector2f origin_;              // c_I of lens (0, 0)
  Eigen::Matrix2f lattice_from_px_;
  int min_i_ = 0, min_j_ = 0, size_i_ = 0, size_j_ = 0;
  std::vector<int> index_;  // of lens (i, j), -1 if there is none
  std::vector<Lens> lenses_;
  std::vector<Offset> offsets_;  // from a lens, by length
  // From the lens (floor(u), floor(v)) to those around the centre of each part of the cell (u, v)
  // of the lattice, by distance from it.
  std::vector<Offset> cell_offsets_[kCells][kCells];
  Image<uint8_t> colour_mask_;
};

}  // namespace prism
