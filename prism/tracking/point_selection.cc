// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/point_selection.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace prism {
namespace {

// Squared gradient threshold of each region: (median + margin)^2, averaged over 3 x 3 regions.
class RegionThresholds {
 public:
  RegionThresholds(const ImageViewF& squared_gradient, const PointSelectionOptions& options)
      : region_size_(options.region_size),
        columns_((squared_gradient.width + region_size_ - 1) / region_size_),
        rows_((squared_gradient.height + region_size_ - 1) / region_size_) {
    ImageF raw(columns_, rows_);
    std::vector<float> values;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        values.clear();
        const int y1 = std::min((row + 1) * region_size_, squared_gradient.height);
        const int x1 = std::min((column + 1) * region_size_, squared_gradient.width);
        for (int y = row * region_size_; y < y1; ++y) {
          for (int x = column * region_size_; x < x1; ++x) values.push_back(squared_gradient(x, y));
        }
        std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
        raw(column, row) =
            static_cast<float>(std::sqrt(values[values.size() / 2]) + options.gradient_margin);
      }
    }
    squared_ = ImageF(columns_, rows_);
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        float sum = 0;
        int count = 0;
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
          for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
            sum += raw(x, y);
            ++count;
          }
        }
        squared_(column, row) = (sum / count) * (sum / count);
      }
    }
  }

  float SquaredAt(int x, int y) const { return squared_(x / region_size_, y / region_size_); }

 private:
  int region_size_, columns_, rows_;
  ImageF squared_;
};

// The strongest usable pixel above `factor` times the threshold in each cell that `is_free`.
template <typename IsFree>
void SelectInCells(const ImageViewF& squared_gradient,
                   const RegionThresholds& thresholds,
                   const std::vector<uint8_t>& usable,
                   int border,
                   int cell_size,
                   float factor,
                   const IsFree& is_free,
                   std::vector<Eigen::Vector2i>* points) {
  const int width = squared_gradient.width;
  const int height = squared_gradient.height;
  for (int y0 = border; y0 < height - border; y0 += cell_size) {
    for (int x0 = border; x0 < width - border; x0 += cell_size) {
      if (!is_free(x0, y0)) continue;
      float best = 0;
      Eigen::Vector2i best_px(-1, -1);
      for (int y = y0; y < std::min(y0 + cell_size, height - border); ++y) {
        for (int x = x0; x < std::min(x0 + cell_size, width - border); ++x) {
          const float squared = squared_gradient(x, y);
          if (squared > best && squared > factor * thresholds.SquaredAt(x, y) &&
              usable[static_cast<size_t>(y) * width + x]) {
            best = squared;
            best_px = {x, y};
          }
        }
      }
      if (best > 0) points->push_back(best_px);
    }
  }
}

}  // namespace

bool PointSelectionOptions::IsValid(std::string* error) const {
  if (region_size >= 4 && gradient_margin >= 0 && border >= 3 && max_cell_size >= 2) return true;
  *error =
      "point selection needs regions of 4 px or more, a margin of 0 or more, a border of 3 px "
      "or more and cells of 2 px or more";
  return false;
}

std::vector<Eigen::Vector2i> SelectPoints(const ImageViewF& squared_gradient,
                                          int count,
                                          const std::function<bool(int x, int y)>& is_usable,
                                          const PointSelectionOptions& options) {
  const int width = squared_gradient.width;
  const int height = squared_gradient.height;
  if (count <= 0) return {};
  const RegionThresholds thresholds(squared_gradient, options);
  constexpr float kWeakFactor = 0.25f;  // of the squared threshold
  std::vector<uint8_t> usable(static_cast<size_t>(width) * height, 0);
  for (int y = options.border; y < height - options.border; ++y) {
    for (int x = options.border; x < width - options.border; ++x) {
      usable[static_cast<size_t>(y) * width + x] =
          squared_gradient(x, y) > kWeakFactor * thresholds.SquaredAt(x, y) && is_usable(x, y);
    }
  }

  const auto select = [&](int cell_size) {
    std::vector<Eigen::Vector2i> points;
    SelectInCells(
        squared_gradient,
        thresholds,
        usable,
        options.border,
        cell_size,
        1.0f,
        [](int, int) { return true; },
        &points);
    // Cells of the second pass that already hold a point stay as they are.
    const int wide = 2 * cell_size;
    const int columns = (width + wide - 1) / wide;
    std::vector<uint8_t> taken(static_cast<size_t>(columns) * ((height + wide - 1) / wide), 0);
    const auto wide_cell = [&](int x, int y) -> uint8_t& {
      return taken[static_cast<size_t>((y - options.border) / wide) * columns +
                   (x - options.border) / wide];
    };
    for (const Eigen::Vector2i& p : points) wide_cell(p.x(), p.y()) = 1;
    SelectInCells(
        squared_gradient,
        thresholds,
        usable,
        options.border,
        wide,
        kWeakFactor,
        [&](int x, int y) { return wide_cell(x, y) == 0; },
        &points);
    return points;
  };

  // The number of points falls with the cell size: find the smallest cells with at most `count`.
  int low = 2, high = options.max_cell_size;
  while (low < high) {
    const int middle = (low + high) / 2;
    if (static_cast<int>(select(middle).size()) > count) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  // One size finer has more than wanted; thinning it evenly comes closest to the count.
  std::vector<Eigen::Vector2i> points = select(std::max(low - 1, 2));
  if (static_cast<int>(points.size()) <= count) return points;
  std::vector<Eigen::Vector2i> thinned;
  thinned.reserve(count);
  for (int i = 0; i < count; ++i) {
    thinned.push_back(points[static_cast<size_t>(i) * points.size() / count]);
  }
  return thinned;
}

}  // namespace prism
