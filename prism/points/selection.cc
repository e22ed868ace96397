// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/selection.h"

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

// A pixel that may be selected, with its gradient relative to the region's threshold.
struct UsablePixel {
  Eigen::Vector2i px;
  float squared_gradient;
  bool is_strong;  // above the threshold itself, not only above its weak fraction
};

// The pixel of strongest gradient in each cell, among those that pass `is_wanted`, in the order of
// the cells.
template <typename IsWanted>
std::vector<Eigen::Vector2i> StrongestInCells(const std::vector<UsablePixel>& pixels,
                                              int width,
                                              int height,
                                              int cell_size,
                                              const IsWanted& is_wanted) {
  const int columns = (width + cell_size - 1) / cell_size;
  const int rows = (height + cell_size - 1) / cell_size;
  std::vector<const UsablePixel*> best(static_cast<size_t>(columns) * rows, nullptr);
  for (const UsablePixel& pixel : pixels) {
    if (!is_wanted(pixel)) continue;
    const UsablePixel*& strongest =
        best[static_cast<size_t>(pixel.px.y() / cell_size) * columns + pixel.px.x() / cell_size];
    if (strongest == nullptr || pixel.squared_gradient > strongest->squared_gradient) {
      strongest = &pixel;
    }
  }
  std::vector<Eigen::Vector2i> points;
  for (const UsablePixel* pixel : best) {
    if (pixel != nullptr) points.push_back(pixel->px);
  }
  return points;
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
  std::vector<UsablePixel> pixels;
  for (int y = options.border; y < height - options.border; ++y) {
    for (int x = options.border; x < width - options.border; ++x) {
      const float squared = squared_gradient(x, y);
      const float threshold = thresholds.SquaredAt(x, y);
      if (squared > kWeakFactor * threshold && is_usable(x, y)) {
        pixels.push_back({{x, y}, squared, squared > threshold});
      }
    }
  }

  const auto select = [&](int cell_size) {
    std::vector<Eigen::Vector2i> points = StrongestInCells(
        pixels, width, height, cell_size, [](const UsablePixel& pixel) { return pixel.is_strong; });
    // Wide cells of the second pass that already hold a point stay as they are.
    const int wide = 2 * cell_size;
    const int columns = (width + wide - 1) / wide;
    std::vector<bool> taken(static_cast<size_t>(columns) * ((height + wide - 1) / wide), false);
    const auto wide_cell = [&](const Eigen::Vector2i& px) {
      return static_cast<size_t>(px.y() / wide) * columns + px.x() / wide;
    };
    for (const Eigen::Vector2i& px : points) taken[wide_cell(px)] = true;
    const std::vector<Eigen::Vector2i> weak =
        StrongestInCells(pixels, width, height, wide, [&](const UsablePixel& pixel) {
          return !taken[wide_cell(pixel.px)];
        });
    points.insert(points.end(), weak.begin(), weak.end());
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
