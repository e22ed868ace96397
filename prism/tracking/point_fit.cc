// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/tracking/point_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "prism/image/patch.h"

namespace prism {
namespace {

// Sums over the samples of a point.
struct PatternSums {
  int seen = 0;
  double r = 0, r2 = 0;  // residuals
  double weighted_r2 = 0;
  double i = 0, i2 = 0;  // intensities expected in the frame
};

PointFit Judge(const PatternSums& sums, double sigma) {
  constexpr double kMaxRms = 2.5;       // sigma
  constexpr double kMaxLost = 0.6;      // of the pattern's variance
  constexpr double kClearContrast = 2;  // sigma: with less, nobody can tell if texture is there
  if (sums.seen == 0) return PointFit::kUnseen;
  if (sums.weighted_r2 > kMaxRms * kMaxRms * sigma * sigma * sums.seen) return PointFit::kOutlier;
  const double variance = (sums.i2 - sums.i * sums.i / sums.seen) / sums.seen;
  const double lost = (sums.r2 - sums.r * sums.r / sums.seen) / sums.seen;
  const bool is_clear = variance > kClearContrast * kClearContrast * sigma * sigma;
  return is_clear && lost > kMaxLost * variance ? PointFit::kOutlier : PointFit::kFits;
}

}  // namespace

PointFits JudgePoints(const TrackingReference& reference,
                      const ImageViewF& target_image,
                      const AlignmentState& state,
                      const std::vector<double>& rho,
                      const NoiseModel& noise) {
  std::vector<PatternSums> sums(reference.points.size());
  const RelativeState relative{state.target_from_reference, std::exp(state.a), state.b};
  const PlenopticProjection& camera = reference.cameras[0];
  const TrackingReference::Level& level = reference.levels[0];
  PixelResiduals residuals;
  std::array<double, kPixelBatch> rho_of;
  for (size_t first = 0; first < level.pixels.size(); first += kPixelBatch) {
    const auto point_of = [&](size_t i) { return (first + i) / kPatternSize; };
    for (size_t i = 0; i < kPixelBatch; ++i) {
      rho_of[i] = point_of(i) < rho.size() ? rho[point_of(i)] : 0;
    }
    EvaluatePixels(level.pixels,
                   first,
                   rho_of.data(),
                   relative,
                   camera,
                   target_image,
                   /*with_jacobians=*/false,
                   &residuals);
    for (size_t i = 0; i < kPixelBatch; ++i) {
      if (residuals.seen[i] == 0) continue;
      const double r = residuals.value()[i];
      const double expected = relative.gain * level.pixels.intensity()[first + i];
      PatternSums& point = sums[point_of(i)];
      ++point.seen;
      point.r += r;
      point.r2 += r * r;
      point.weighted_r2 += level.pixels.weight()[first + i] * r * r;
      point.i += expected;
      point.i2 += expected * expected;
    }
  }

  constexpr int kCells = 8;  // across the image
  constexpr int kMinPoints = 5;
  struct Cell {
    int seen = 0, outliers = 0;
  };
  const double size = std::max(camera.width, camera.height) / static_cast<double>(kCells);
  const auto cell_of = [&](const ReferencePoint& point) {
    return std::make_pair(static_cast<int>(point.px.x() / size),
                          static_cast<int>(point.px.y() / size));
  };
  std::map<std::pair<int, int>, Cell> cells;
  PointFits result;
  std::vector<PointFit>& fits = result.fits;
  for (size_t i = 0; i < sums.size(); ++i) {
    fits.push_back(Judge(sums[i], noise.FitSigma()));
    if (fits[i] == PointFit::kUnseen) continue;
    Cell& cell = cells[cell_of(reference.points[i])];
    ++cell.seen;
    cell.outliers += fits[i] == PointFit::kOutlier;
  }
  const auto is_hidden = [](const Cell& cell) {
    return cell.seen >= kMinPoints && 2 * cell.outliers > cell.seen;
  };
  int cells_seen = 0, cells_hidden = 0;
  for (const auto& [index, cell] : cells) {
    cells_seen += cell.seen >= kMinPoints;
    cells_hidden += is_hidden(cell);
  }
  if (cells_seen > 0) result.misfit_area = static_cast<double>(cells_hidden) / cells_seen;
  double r2 = 0;
  int samples = 0;
  for (size_t i = 0; i < fits.size(); ++i) {
    if (fits[i] == PointFit::kUnseen) continue;
    if (is_hidden(cells[cell_of(reference.points[i])])) fits[i] = PointFit::kOutlier;
    if (reference.points[i].is_excluded) continue;
    ++result.seen;
    if (fits[i] == PointFit::kOutlier) {
      ++result.outliers;
    } else {
      r2 += sums[i].r2;
      samples += sums[i].seen;
    }
  }
  if (samples > 0) result.rms = std::sqrt(r2 / samples);
  return result;
}

}  // namespace prism
