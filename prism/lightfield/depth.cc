// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glog/logging.h>
#include <tbb/parallel_for.h>

#include "prism/base/statistics.h"
#include "prism/camera/projection.h"
#include "prism/lightfield/defocus_match.h"
#include "prism/lightfield/depth_sweep.h"
#include "prism/lightfield/patch_samples.h"

namespace prism {

namespace {

// Variance of one gradient component of the interpolated smooth image over that of gray's noise.
constexpr float kGradientNoise = 0.115f;
constexpr float kLastStep = 0.003f;  // of 1/v: a Gauss-Newton step this small is the last
constexpr float kMaskReach = 0.01f;  // of 1/v: a quarter of a pixel between neighbouring lenses
constexpr int kDraftStep = 2;        // nodes, in x and in y
constexpr int kDraftsAround = 2;

constexpr float kFarTexture = 1.6f * kPatchSigma;  // from its node, in the micro images

// Half-pixel images of a frame are kept as a whole up to this size, bytes; making them in bands is
// no faster.
constexpr size_t kManyBytes = size_t{128} << 20;
constexpr int kLeastBand = 128;  // rows a band of larger ones moves on, at least; raw px

using Samples = std::array<PatchSample, LensTable::kMaxViews>;

// Sum of |d(x, y)/dw|^2.
float BaselineSquared(const Samples& samples, int count) {
  float sum = 0;
  for (int k = 0; k < count; ++k) {
    sum += samples[k].dx * samples[k].dx + samples[k].dy * samples[k].dy;
  }
  return sum;
}

// What noise alone adds to PatchSums::hessian: the sum of p |d(x, y)/dw|^2 times the gradient's
// variance.
float NoiseHessian(float baseline_squared, int count, const PatchSums& sums, float noise) {
  return kGradientNoise * noise * noise * sums.freedom * baseline_squared /
         static_cast<float>(count);
}

// What noise alone adds to PatchSums::gradient: the gain makes its variance grow towards the rim of
// a micro image, and the patches would go where there is less. The variance of shot noise is
// proportional to the gain.
float NoiseGradient(const PreparedRaw& raw, const LensView* views, int count, float smooth_noise) {
  if (raw.gain_slope_x.empty()) return 0;
  float sum = 0;
  for (int k = 0; k < count; ++k) {
    const int x = static_cast<int>(std::lround(views[k].x));
    const int y = static_cast<int>(std::lround(views[k].y));
    sum += static_cast<float>(raw.gain_slope_x(x, y)) * views[k].dx +
           static_cast<float>(raw.gain_slope_y(x, y)) * views[k].dy;
  }
  return 0.5f * smooth_noise * smooth_noise * kGainSlopeUnit * sum *
         (1 - 1 / static_cast<float>(count));
}

// Where a search begins that is not told where.
double NearestInverseVirtualDepth(const PlenopticCamera& camera) {
  constexpr double kNearest = 0.2;  // m
  constexpr double kLeast = 0.05, kMost = 0.1;
  std::string error;
  if (camera.mode == MicroLensMode::kKeplerian || !camera.HasMetricDepth(&error)) return kMost;
  return std::clamp(InverseVirtualDepth(PlenopticProjection(camera), 1 / kNearest), kLeast, kMost);
}

}  // namespace

bool DepthOptions::IsValid(std::string* error) const {
  if (!(min_inverse_virtual_depth >= 0 && min_inverse_virtual_depth < max_inverse_virtual_depth &&
        max_inverse_virtual_depth <= 0.5)) {
    *error = "search range of 1/v from " + std::to_string(min_inverse_virtual_depth) + " to " +
             std::to_string(max_inverse_virtual_depth) +
             ", expected 0 <= min < max <= 0.5 (from 0: as near as the camera needs)";
  } else if (!(search_step * (SweepRange::kMaxHypotheses - 1) >=
               max_inverse_virtual_depth - min_inverse_virtual_depth)) {
    *error = "search_step of " + std::to_string(search_step) + ", expected at most 63 steps";
  } else if (!(seed_spacing >= 1 && seed_spacing <= 20)) {
    *error = "seed_spacing of " + std::to_string(seed_spacing) + ", expected 1 to 20";
  } else if (!(min_gradient >= 0 && max_sigma > 0 && ambiguity >= 1 && max_residual > 0 &&
               sigma_floor >= 0 && noise_factor > 0 && misfit_factor >= 0)) {
    *error =
        "a negative threshold, expected min_gradient, max_sigma, max_residual, sigma_floor, "
        "noise_factor, misfit_factor >= 0 and ambiguity >= 1";
  } else {
    return true;
  }
  return false;
}

DepthEstimator::DepthEstimator(const PlenopticCamera& camera,
                               const LensTable& lenses,
                               const DepthOptions& options)
    : width_(camera.focused_width()),
      height_(camera.focused_height()),
      scale_(camera.focused_scale),
      lenses_(lenses),
      options_(options),
      seeds_(width_, height_, options.seed_spacing, 1),
      drafts_(width_, height_, kDraftStep * kNodeSpacing, kDraftsAround),
      nodes_(width_, height_),
      fused_(width_, height_) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  if (options_.min_inverse_virtual_depth == 0) {
    options_.min_inverse_virtual_depth = NearestInverseVirtualDepth(camera);
  }
  int rows = 0;
  const auto include = [&](const std::pair<int, int>& looked_at) {
    rows = std::max(rows, looked_at.second - looked_at.first + kLeastBand);
  };
  for (int j = 0; j < seeds_.height; ++j) include(RowsOfCells(j, j + 1));
  for (int j = 0; j < nodes_.height(); ++j) include(RowsOfNodes(j, j + 1));
  const bool is_smoothed_twice = lenses.HasSeveralFocalLengths();
  const size_t bytes_a_row = (is_smoothed_twice ? 32 : 16) * static_cast<size_t>(lenses.width());
  rows = std::max(rows, static_cast<int>(kManyBytes / bytes_a_row));
  rows_ = SmoothRows(lenses.width(), lenses.height(), rows, is_smoothed_twice);
}

DepthEstimator::Cells::Cells(int image_width, int image_height, int side, int around)
    : side(side),
      around(around),
      width((image_width + side - 1) / side),
      height((image_height + side - 1) / side),
      estimates(static_cast<size_t>(width) * height) {}

template <typename Visit>
void DepthEstimator::Cells::ForEachAround(int i, int j, int cells, const Visit& visit) const {
  for (int v = std::max(j - cells, 0); v <= std::min(j + cells, height - 1); ++v) {
    for (int u = std::max(i - cells, 0); u <= std::min(i + cells, width - 1); ++u) {
      if ((*this)(u, v).w > 0) visit((*this)(u, v));
    }
  }
}

std::pair<int, int> DepthEstimator::RowsLookedAt(float Y0, float Y1, float beside_px) const {
  const float w0 = static_cast<float>(options_.min_inverse_virtual_depth);
  const float w1 = static_cast<float>(options_.max_inverse_virtual_depth);
  // A point whose images move by that is seen by lenses as far away as with larger micro images.
  const auto rows = lenses_.RowsAround(Y0, Y1, w0, w1, lenses_.radius_px() + beside_px);
  const float margin = kPatchMargin + kMaskReach * rows.longest_motion;
  const float height = static_cast<float>(lenses_.height());
  return {static_cast<int>(std::clamp(rows.first - margin, 0.0f, height)),
          static_cast<int>(std::clamp(rows.last + margin + 1, 0.0f, height))};
}

std::pair<int, int> DepthEstimator::RowsOfCells(int begin, int end) const {
  const float spacing = static_cast<float>(options_.seed_spacing);
  return RowsLookedAt(RawPosition(0, static_cast<float>(begin) * spacing - 0.5f).y(),
                      RawPosition(0, static_cast<float>(end) * spacing - 0.5f).y(),
                      0);
}

// Texture may lie beside its node.
std::pair<int, int> DepthEstimator::RowsOfNodes(int begin, int end) const {
  return RowsLookedAt(RawPosition(0, static_cast<float>(NodePixel(begin))).y(),
                      RawPosition(0, static_cast<float>(NodePixel(end - 1))).y(),
                      kFarTexture);
}

template <typename RowsOf, typename Row>
void DepthEstimator::ForRows(int count, const RowsOf& rows_of, const Row& row) {
  for (int begin = 0, end = 0; begin < count; begin = end) {
    std::pair<int, int> rows = rows_of(begin, begin + 1);
    for (end = begin + 1; end < count; ++end) {
      const std::pair<int, int> more = rows_of(begin, end + 1);
      if (more.second - more.first > rows_.room()) break;
      rows = more;
    }
    rows_.MoveTo(rows.first, rows.second);
    tbb::parallel_for(begin, end, row);
  }
}

DepthEstimator::Estimated DepthEstimator::Refine(const PreparedRaw& raw,
                                                 const Eigen::Vector2f& raw_px,
                                                 float w,
                                                 int iterations) const {
  LensView views[LensTable::kMaxViews];
  Samples samples;
  const float noise = static_cast<float>(texture_.noise()) * kSmoothNoise;
  const DefocusMatch match(lenses_.focus_of_type(), lenses_.DefocusVariance(), w);
  const int count = lenses_.ViewsOf(raw_px.x(),
                                    raw_px.y(),
                                    w,
                                    lenses_.radius_px() - 1,
                                    kPatchMargin,
                                    match.types(),
                                    kMaxComparedViews,
                                    views);
  if (count < 2) return {};
  const float start = w;
  const float max_step = static_cast<float>(options_.search_step);
  const uint8_t* colours[LensTable::kMaxViews] = {};
  PatchSums sums{};
  float cost = 0;
  for (int iteration = 1;; ++iteration) {
    PlaceSamples(raw, rows_, lenses_, match, views, count, samples.data());
    for (int k = 0; k < count; ++k) {
      // The mask stays where it was: patches that move outwards would lose samples at the rim, and
      // an estimate too large would be dropped more often than one too small.
      if (iteration == 1) colours[k] = samples[k].colours;
      samples[k].colours = colours[k];
    }
    sums = SumPatches(samples.data(), count, raw.gray.width());
    if (!(sums.hessian > 0)) return {};
    sums.gradient -= NoiseGradient(raw, views, count, noise);
    const float step = std::clamp(-sums.gradient / sums.hessian, -max_step, max_step);
    w += step;
    if (std::abs(w - start) > kMaskReach) return {};
    // What is left after a step as small as this is its quadratic model's.
    cost = sums.cost + step * (2 * sums.gradient + step * sums.hessian);
    if (std::abs(step) < kLastStep) break;
    if (iteration == iterations) return {};
    for (int k = 0; k < count; ++k) {
      views[k].x += step * views[k].dx;
      views[k].y += step * views[k].dy;
      if (!raw.gray.view().Contains(views[k].x, views[k].y, kPatchMargin)) return {};
    }
  }
  if (!(w >= options_.min_inverse_virtual_depth && w <= options_.max_inverse_virtual_depth) ||
      sums.freedom < 4) {
    return {};
  }
  const float gray_noise = static_cast<float>(texture_.noise());
  const float baseline_squared = BaselineSquared(samples, count);
  const float noise_hessian = NoiseHessian(baseline_squared, count, sums, gray_noise);
  const float hessian = sums.hessian - noise_hessian;
  if (hessian < options_.min_information * noise_hessian) return {};
  Estimated result;
  result.w = w;
  result.residual = std::max(cost, 0.0f) / sums.freedom / (noise * noise);
  result.noise_variance = std::max(result.residual, 1.0f) * noise * noise / hessian;
  // Of a gradient in any direction, half its square is along the baseline.
  result.baseline_squared = 0.5f * baseline_squared;
  result.contrast = hessian / (sums.freedom * noise * noise * result.baseline_squared) *
                    static_cast<float>(count);
  result.shift = Eigen::Vector2f(sums.moment_x, sums.moment_y) /
                 (hessian * lenses_.Magnification(w) * static_cast<float>(scale_));
  return result;
}

bool DepthEstimator::Accept(Estimated* estimated) const {
  const auto square = [](double x) { return x * x; };
  const double variance =
      square(options_.noise_factor) * estimated->noise_variance +
      square(options_.misfit_factor * misfit_.share_px) / estimated->baseline_squared +
      square(options_.sigma_floor);
  estimated->sigma = static_cast<float>(std::sqrt(variance));
  return estimated->sigma <= options_.max_sigma &&
         estimated->residual <= square(options_.max_residual) * misfit_.Expect(estimated->contrast);
}

void DepthEstimator::AcceptSeeds() {
  std::vector<MatchSample> samples;
  for (const Estimated& seed : seeds_.estimates) {
    if (seed.w > 0) samples.push_back({seed.contrast, seed.residual});
  }
  misfit_ = FitMisfit(std::move(samples));
  for (Estimated& seed : seeds_.estimates) {
    if (seed.w > 0 && !Accept(&seed)) seed = {};
  }
}

void DepthEstimator::DropTruncatedSeeds() {
  // In search steps: a minimum is up to half of one from the hypothesis that needs one more above
  // it, and its noise is some 0.4.
  constexpr float kMargin = 1.3f;
  constexpr float kSameSurface = 1.5f;
  constexpr int kCellsAround = 2;
  const float step = static_cast<float>(options_.search_step);
  const float last = static_cast<float>(options_.max_inverse_virtual_depth) - step;
  std::vector<Estimated*> truncated;
  std::vector<double> others;
  for (int j = 0; j < seeds_.height; ++j) {
    for (int i = 0; i < seeds_.width; ++i) {
      Estimated& seed = seeds_(i, j);
      if (seed.w == 0 || seed.limit > last) continue;
      // What 1/v is there is asked of its neighbours: its own noise decides nothing then.
      others.clear();
      seeds_.ForEachAround(i, j, kCellsAround, [&](const Estimated& other) {
        if (&other != &seed && std::abs(other.w - seed.w) < kSameSurface * step) {
          others.push_back(other.w);
        }
      });
      if (others.empty()) others.push_back(seed.w);
      const float there = static_cast<float>(UpperMedian(others));
      if (seed.limit < there + kMargin * step) truncated.push_back(&seed);
    }
  }
  for (Estimated* seed : truncated) *seed = {};
}

Eigen::Vector2f DepthEstimator::RawPosition(float x, float y) const {
  const float scale = static_cast<float>(scale_);
  return {(x + 0.5f) * scale - 0.5f, (y + 0.5f) * scale - 0.5f};
}

int DepthEstimator::TextureAt(const Eigen::Vector2f& raw_px) const {
  constexpr float kMiddle = 0.3f;  // of the range of 1/v
  LensView view;
  const int count = lenses_.ViewsOf(raw_px.x(),
                                    raw_px.y(),
                                    kMiddle,
                                    lenses_.radius_px(),
                                    kPatchMargin,
                                    LensTable::kAllTypes,
                                    1,
                                    &view);
  return count == 0 ? 0 : texture_.CountAround(view.x, view.y);
}

DepthEstimator::Estimated DepthEstimator::SearchCell(const PreparedRaw& raw, int i, int j) const {
  constexpr int kMinTexture = 8;  // px
  const float spacing = static_cast<float>(options_.seed_spacing);
  int most = kMinTexture - 1;
  Eigen::Vector2f seed;
  for (const float v : {0.25f, 0.75f}) {
    for (const float u : {0.25f, 0.75f}) {
      const Eigen::Vector2f raw_px = RawPosition((static_cast<float>(i) + u) * spacing - 0.5f,
                                                 (static_cast<float>(j) + v) * spacing - 0.5f);
      const int texture = TextureAt(raw_px);
      if (texture <= most) continue;
      most = texture;
      seed = raw_px;
    }
  }
  if (most < kMinTexture) return {};
  const SweepRange range{static_cast<float>(options_.min_inverse_virtual_depth),
                         static_cast<float>(options_.max_inverse_virtual_depth),
                         static_cast<float>(options_.search_step),
                         static_cast<float>(options_.ambiguity)};
  const float noise = static_cast<float>(texture_.noise()) * kSmoothNoise;
  const std::optional<SweepMinimum> minimum =
      SweepInverseVirtualDepth(raw, rows_, lenses_, range, noise, seed.x(), seed.y());
  if (!minimum) return {};
  Estimated result = Refine(raw, seed, minimum->w, 6);
  result.limit = minimum->limit;
  return result;
}

DepthEstimator::Estimated DepthEstimator::RefineFrom(const Cells& starts,
                                                     const PreparedRaw& raw,
                                                     int x,
                                                     int y) const {
  constexpr float kSameSurface = 0.02f;  // of 1/v
  const int i = x / starts.side;
  const int j = y / starts.side;
  const Eigen::Vector2f raw_px = RawPosition(static_cast<float>(x), static_cast<float>(y));
  // Those that agree with the most certain one around, and the most certain that disagrees.
  const Estimated* first = nullptr;
  const Estimated* second = nullptr;
  starts.ForEachAround(i, j, starts.around, [&](const Estimated& start) {
    if (!first || start.sigma < first->sigma) first = &start;
  });
  if (!first) return {};
  float sum = 0;
  int agree = 0;
  starts.ForEachAround(i, j, starts.around, [&](const Estimated& start) {
    if (std::abs(start.w - first->w) <= kSameSurface) {
      sum += start.w;
      ++agree;
    } else if (!second || start.sigma < second->sigma) {
      second = &start;
    }
  });
  // The mean of several depends less on the noise of this patch, which is that of the nearest one.
  Estimated result = Refine(raw, raw_px, sum / static_cast<float>(agree), 3);
  if (second) {
    const Estimated other = Refine(raw, raw_px, second->w, 3);
    if (other.w > 0 && (result.w == 0 || other.residual < result.residual)) result = other;
  }
  return result.w > 0 && Accept(&result) ? MoveToTexture(raw, raw_px, result) : Estimated();
}

DepthEstimator::Estimated DepthEstimator::MoveToTexture(const PreparedRaw& raw,
                                                        const Eigen::Vector2f& raw_px,
                                                        Estimated estimated) const {
  // Of a shift, in the micro images.
  constexpr float kNear = 0.4f * kPatchSigma;
  constexpr int kMostMoves = 2;
  const float scale = static_cast<float>(scale_);
  const float raw_px_of_focused = scale * estimated.w;
  Eigen::Vector2f shift = estimated.shift;
  for (int moves = 0;; ++moves) {
    if (raw_px_of_focused * shift.norm() > kFarTexture) return {};
    if (raw_px_of_focused * estimated.shift.norm() <= kNear) break;
    if (moves == kMostMoves) return {};
    estimated = Refine(raw, raw_px + scale * shift, estimated.w, 3);
    if (estimated.w == 0 || !Accept(&estimated)) return {};
    shift += estimated.shift;
  }
  estimated.shift = shift;
  return estimated;
}

Eigen::Vector2f DepthEstimator::ToPixel(int i, int j, const Estimated& estimated) const {
  if (estimated.w == 0) return Eigen::Vector2f::Zero();
  const Eigen::Vector2f node(static_cast<float>(NodePixel(i)), static_cast<float>(NodePixel(j)));
  const Eigen::Vector2f raw_px =
      RawPosition(node.x(), node.y()) + static_cast<float>(scale_) * estimated.shift;
  return (lenses_.PixelOf(raw_px, estimated.w) - raw_px) / static_cast<float>(scale_);
}

float DepthEstimator::Reach(float w) const {
  constexpr float kSigmas = 2.4f;          // of a patch
  constexpr float kLeast = 6, kMost = 10;  // focused px
  if (w == 0) return 0;
  return std::clamp(kSigmas * kPatchSigma / (w * static_cast<float>(scale_)), kLeast, kMost);
}

void DepthEstimator::Estimate(const PreparedRaw& raw,
                              ImageF* inverse_virtual_depth,
                              ImageF* sigma) {
  texture_.Measure(raw, options_.min_gradient);
  rows_.Begin(raw.gray);
  const auto rows_of_cells = [&](int begin, int end) { return RowsOfCells(begin, end); };
  ForRows(seeds_.height, rows_of_cells, [&](int j) {
    for (int i = 0; i < seeds_.width; ++i) seeds_(i, j) = SearchCell(raw, i, j);
  });
  AcceptSeeds();
  DropTruncatedSeeds();
  const auto rows_of_drafts = [&](int begin, int end) {
    return RowsOfNodes(kDraftStep * begin, kDraftStep * (end - 1) + 1);
  };
  ForRows(drafts_.height, rows_of_drafts, [&](int j) {
    for (int i = 0; i < drafts_.width; ++i) {
      const int x = NodePixel(kDraftStep * i);
      const int y = NodePixel(kDraftStep * j);
      drafts_(i, j) = x < width_ && y < height_ ? RefineFrom(seeds_, raw, x, y) : Estimated();
    }
  });
  const auto rows_of_nodes = [&](int begin, int end) { return RowsOfNodes(begin, end); };
  ForRows(nodes_.height(), rows_of_nodes, [&](int j) {
    for (int i = 0; i < nodes_.width(); ++i) {
      const Estimated estimated = RefineFrom(drafts_, raw, NodePixel(i), NodePixel(j));
      const Eigen::Vector2f shift = estimated.shift + ToPixel(i, j, estimated);
      nodes_.depth(i, j) = estimated.w;
      nodes_.sigma(i, j) = estimated.sigma;
      nodes_.shift_x(i, j) = shift.x();
      nodes_.shift_y(i, j) = shift.y();
      nodes_.reach(i, j) = Reach(estimated.w);
    }
  });
  rows_.Release();
  FuseNeighbours(nodes_, &fused_);
  SpreadNodes(fused_, inverse_virtual_depth, sigma);
}

}  // namespace prism
