// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/lens_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glog/logging.h>
#include <Eigen/LU>

#include "prism/camera/projection.h"

namespace prism {
namespace {

// Diameter of a micro lens over the pitch, as usual for arrays with a dark border between lenses.
constexpr float kMicroLensFill = 0.9f;
constexpr int kOffsetReach = 8;  // lattice steps; v radius beyond that exceeds kMaxViews

Lens MakeLens(const PlenopticCamera& camera, const LensIndex& index) {
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  const Eigen::Vector2d image = grid.MicroImageCenter(index, camera.raw_width, camera.raw_height);
  const Eigen::Vector2d center = UndistortRaw(camera, image);
  const Eigen::Vector2d lens = MicroLensCenter(camera, center);
  constexpr double kStep = 0.5;  // px
  const Eigen::Vector2d ax = DistortRaw(camera, center + Eigen::Vector2d(kStep, 0)) -
                             DistortRaw(camera, center - Eigen::Vector2d(kStep, 0));
  const Eigen::Vector2d ay = DistortRaw(camera, center + Eigen::Vector2d(0, kStep)) -
                             DistortRaw(camera, center - Eigen::Vector2d(0, kStep));
  Lens result;
  result.image_x = static_cast<float>(image.x());
  result.image_y = static_cast<float>(image.y());
  result.center_x = static_cast<float>(center.x());
  result.center_y = static_cast<float>(center.y());
  result.lens_x = static_cast<float>(lens.x());
  result.lens_y = static_cast<float>(lens.y());
  result.axx = static_cast<float>(ax.x());
  result.ayx = static_cast<float>(ax.y());
  result.axy = static_cast<float>(ay.x());
  result.ayy = static_cast<float>(ay.y());
  result.i = index.i;
  result.j = index.j;
  result.type = grid.TypeOf(index);
  const int sign = grid.base_x.dot(grid.base_y) > 0 ? -1 : 1;
  result.colour = ((index.i + sign * index.j) % 3 + 3) % 3;
  return result;
}

}  // namespace

LensTable::LensTable(const PlenopticCamera& camera)
    : width_(camera.raw_width),
      height_(camera.raw_height),
      sign_(static_cast<float>(camera.virtual_depth_sign())) {
  CHECK(camera.micro_lens_grid);
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  pitch_px_ = static_cast<float>(grid.diameter_px);
  radius_px_ = static_cast<float>(0.5 * grid.diameter_px - grid.lens_border_px);
  for (const MicroLensType& type : grid.types) {
    focus_of_type_.push_back(static_cast<float>(type.FocusInverseVirtualDepth()));
  }
  principal_ = camera.raw_principal_point.cast<float>();
  eq8_scale_ =
      camera.adjust_micro_lens_centers
          ? static_cast<float>(camera.main_lens_mla_distance /
                               (camera.main_lens_mla_distance + camera.sensor_mla_distance))
          : 1.0f;
  is_of_chief_rays_ = camera.focused_image == FocusedImage::kChiefRays;
  scale_at_array_ = static_cast<float>(camera.main_lens_mla_distance / camera.focal_length);
  scale_per_v_ = static_cast<float>(camera.sensor_mla_distance / camera.focal_length);
  const Eigen::Vector2d origin = grid.MicroImageCenter({0, 0}, width_, height_);
  Eigen::Matrix2d basis;
  basis << grid.MicroImageCenter({1, 0}, width_, height_) - origin,
      grid.MicroImageCenter({0, 1}, width_, height_) - origin;
  const Eigen::Matrix2d lattice_from_px = basis.inverse();
  origin_ = origin.cast<float>();
  lattice_from_px_ = lattice_from_px.cast<float>();

  // Lattice box around the image; lenses whose micro image touches the image.
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const double x : {0.0, width_ - 1.0}) {
    for (const double y : {0.0, height_ - 1.0}) {
      const Eigen::Vector2d corner = lattice_from_px * (Eigen::Vector2d(x, y) - origin);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  min_i_ = static_cast<int>(std::floor(low.x())) - 1;
  min_j_ = static_cast<int>(std::floor(low.y())) - 1;
  size_i_ = static_cast<int>(std::ceil(high.x())) + 2 - min_i_;
  size_j_ = static_cast<int>(std::ceil(high.y())) + 2 - min_j_;
  index_.assign(static_cast<size_t>(size_i_) * size_j_, -1);
  for (int j = min_j_; j < min_j_ + size_j_; ++j) {
    for (int i = min_i_; i < min_i_ + size_i_; ++i) {
      const Eigen::Vector2d center = grid.MicroImageCenter({i, j}, width_, height_);
      if (center.x() < -radius_px_ || center.y() < -radius_px_ ||
          center.x() > width_ - 1 + radius_px_ || center.y() > height_ - 1 + radius_px_) {
        continue;
      }
      index_[static_cast<size_t>(j - min_j_) * size_i_ + (i - min_i_)] =
          static_cast<int>(lenses_.size());
      lenses_.push_back(MakeLens(camera, {i, j}));
      const Lens& lens = lenses_.back();
      stretch_ = std::max(
          stretch_, std::hypot(std::hypot(lens.axx, lens.axy), std::hypot(lens.ayx, lens.ayy)));
      shift_px_ =
          std::max(shift_px_, std::hypot(lens.lens_x - lens.center_x, lens.lens_y - lens.center_y));
    }
  }

  for (int dj = -kOffsetReach; dj <= kOffsetReach; ++dj) {
    for (int di = -kOffsetReach; di <= kOffsetReach; ++di) {
      const float length = static_cast<float>((basis * Eigen::Vector2d(di, dj)).norm());
      if (length < 0.87f * kOffsetReach * pitch_px_) offsets_.push_back({di, dj, length});
    }
  }
  const auto ByLength = [](const Offset& a, const Offset& b) { return a.length_px < b.length_px; };
  std::stable_sort(offsets_.begin(), offsets_.end(), ByLength);
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const Eigen::Vector2d center((column + 0.5) / kCells, (row + 0.5) / kCells);
      std::vector<Offset>& cell = cell_offsets_[row][column];
      for (const Offset& offset : offsets_) {
        const Eigen::Vector2d from_center = Eigen::Vector2d(offset.di, offset.dj) - center;
        cell.push_back({offset.di, offset.dj, static_cast<float>((basis * from_center).norm())});
      }
      std::stable_sort(cell.begin(), cell.end(), ByLength);
    }
  }
  BuildColourMask();
}

void LensTable::BuildColourMask() {
  colour_mask_ = Image<uint8_t>(width_, height_, 0);
  for (const Lens& lens : lenses_) {
    ForEachPixelNear(lens, [&](int x, int y) {
      const float dx = x - lens.image_x;
      const float dy = y - lens.image_y;
      if (dx * dx + dy * dy <= radius_px_ * radius_px_) {
        colour_mask_(x, y) = static_cast<uint8_t>(lens.colour + 1);
      }
    });
  }
}

bool LensTable::HasSeveralFocalLengths() const {
  return std::any_of(focus_of_type_.begin(), focus_of_type_.end(), [this](float focus) {
    return focus != focus_of_type_[0];
  });
}

float LensTable::DefocusVariance() const {
  const float radius = 0.5f * kMicroLensFill * pitch_px_;
  return 0.25f * radius * radius;
}

int LensTable::NearestLens(float x, float y) const {
  const Eigen::Vector2f lattice = lattice_from_px_ * (Eigen::Vector2f(x, y) - origin_);
  return IndexOf(static_cast<int>(std::lround(lattice.x())),
                 static_cast<int>(std::lround(lattice.y())));
}

std::vector<int> LensTable::NeighboursOf(int lens, float max_baseline_px) const {
  std::vector<int> neighbours;
  for (const Offset& offset : offsets_) {
    if (offset.length_px > max_baseline_px) break;
    const int index = IndexOf(lenses_[lens].i + offset.di, lenses_[lens].j + offset.dj);
    if (index >= 0 && index != lens) neighbours.push_back(index);
  }
  return neighbours;
}

Eigen::Vector2f LensTable::ChiefRay(float X, float Y, float w) const {
  const float m = Magnification(w);
  const float to_chief = m / ((m + 1 / eq8_scale_ - 1) * eq8_scale_);
  return to_chief * (Eigen::Vector2f(X, Y) - principal_) + principal_;
}

float LensTable::Reach(float w, float max_radius_px) const {
  // d(offset in the micro image) / d(c_I) = (m + 1/k - 1) k, m the magnification
  return max_radius_px / (std::abs(Magnification(w) + 1 / eq8_scale_ - 1) * eq8_scale_);
}

const std::vector<LensTable::Offset>& LensTable::OffsetsAround(const Eigen::Vector2f& chief,
                                                               int* i,
                                                               int* j) const {
  const Eigen::Vector2f lattice = lattice_from_px_ * (chief - origin_);
  const float u = std::floor(lattice.x());
  const float v = std::floor(lattice.y());
  *i = static_cast<int>(u);
  *j = static_cast<int>(v);
  const int column = std::min(static_cast<int>((lattice.x() - u) * kCells), kCells - 1);
  const int row = std::min(static_cast<int>((lattice.y() - v) * kCells), kCells - 1);
  return cell_offsets_[row][column];
}

int LensTable::LensesAround(float X0,
                            float X1,
                            float Y0,
                            float Y1,
                            float w0,
                            float w1,
                            float max_radius_px,
                            int max_count,
                            int* lenses) const {
  const Eigen::Vector2f corners[] = {ChiefRay(X0, Y0, w0),
                                     ChiefRay(X1, Y0, w0),
                                     ChiefRay(X0, Y1, w0),
                                     ChiefRay(X1, Y1, w0),
                                     ChiefRay(X0, Y0, w1),
                                     ChiefRay(X1, Y0, w1),
                                     ChiefRay(X0, Y1, w1),
                                     ChiefRay(X1, Y1, w1)};
  Eigen::Vector2f center = Eigen::Vector2f::Zero();
  for (const Eigen::Vector2f& corner : corners) center += 0.125f * corner;
  float extent = 0;
  for (const Eigen::Vector2f& corner : corners) {
    extent = std::max(extent, (corner - center).norm());
  }
  const float reach = Reach(std::min(w0, w1), max_radius_px) + extent + cell_radius_px();
  int i, j;
  int count = 0;
  for (const Offset& offset : OffsetsAround(center, &i, &j)) {
    if (offset.length_px > reach || count == max_count) break;
    const int index = IndexOf(i + offset.di, j + offset.dj);
    if (index >= 0) lenses[count++] = index;
  }
  return count;
}

LensTable::RowsOfViews LensTable::RowsAround(
    float Y0, float Y1, float w0, float w1, float max_radius_px) const {
  // ChiefRay and Reach have their poles where this is 0. On either side of it their sum and their
  // difference are monotonic in w, as all (a w + b) / (c w + d) are.
  const auto pole = [&](float w) { return Magnification(w) + 1 / eq8_scale_ - 1; };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  if (w0 <= 0 || pole(w0) * pole(w1) <= 0) return {-kInfinity, kInfinity, kInfinity};
  RowsOfViews rows{kInfinity, -kInfinity, stretch_ * (max_radius_px + shift_px_) / w0};
  for (const float Y : {Y0, Y1}) {
    for (const float w : {w0, w1}) {
      const float y = ChiefRay(0, Y, w).y();
      const float reach = Reach(w, max_radius_px);
      rows.first = std::min(rows.first, y - reach);
      rows.last = std::max(rows.last, y + reach);
    }
  }
  // Lenses are listed by their distance from the middle of the part of a cell that the chief ray
  // lies in; and from the centres of the micro images to the views.
  const float around = 2 * cell_radius_px() + stretch_ * max_radius_px;
  rows.first -= around;
  rows.last += around;
  return rows;
}

int LensTable::ViewsOf(float X,
                       float Y,
                       float w,
                       float max_radius_px,
                       float margin_px,
                       unsigned types,
                       int max_count,
                       LensView* views) const {
  const float reach = Reach(w, max_radius_px) + cell_radius_px();
  const float m = Magnification(w);
  const float max_squared = max_radius_px * max_radius_px;
  int count = 0;
  int i, j;
  for (const Offset& offset : OffsetsAround(ChiefRay(X, Y, w), &i, &j)) {
    if (offset.length_px > reach || count == max_count) break;
    const int index = IndexOf(i + offset.di, j + offset.dj);
    if (index < 0) continue;
    const Lens& lens = lenses_[index];
    if ((types >> lens.type & 1u) == 0) continue;
    const float ex = X - lens.lens_x;
    const float ey = Y - lens.lens_y;
    const float mx = ex * m + lens.lens_x - lens.center_x;
    const float my = ey * m + lens.lens_y - lens.center_y;
    const float squared = mx * mx + my * my;
    if (squared > max_squared) continue;
    LensView& view = views[count];
    view.lens = index;
    view.x = lens.image_x + lens.axx * mx + lens.axy * my;
    view.y = lens.image_y + lens.ayx * mx + lens.ayy * my;
    if (!(view.x >= margin_px && view.y >= margin_px && view.x <= width_ - 1 - margin_px &&
          view.y <= height_ - 1 - margin_px)) {
      continue;
    }
    view.dx = sign_ * (lens.axx * ex + lens.axy * ey);
    view.dy = sign_ * (lens.ayx * ex + lens.ayy * ey);
    view.radius_px = std::sqrt(squared);
    ++count;
  }
  return count;
}

}  // namespace prism
