// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glog/logging.h>
#include <tbb/parallel_for.h>

#include "prism/lightfield/defocus_match.h"
#include "prism/lightfield/depth_fusion.h"
#include "prism/lightfield/patch_kernel.h"

namespace prism {

namespace {

constexpr int kBlock = 8;               // raw px a side of a texture block
constexpr float kSmoothNoise = 0.375f;  // noise of PreparedRaw::smooth over that of gray
// Variance of one gradient component of the interpolated smooth image over that of gray's noise.
constexpr float kGradientNoise = 0.115f;
constexpr float kMargin = kPatchRadius + 8;  // px: the kernel reads kPatchLanes + 1 pixels a row
constexpr int kMaxHypotheses = 64;
constexpr float kLastStep = 0.003f;  // of 1/v: a Gauss-Newton step this small is the last
constexpr float kMaskReach = 0.01f;  // of 1/v: a quarter of a pixel between neighbouring lenses
constexpr int kMaxSearched = 5;      // lenses in the search, nearest to the chief ray first

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
  float sum = 0;
  for (int k = 0; k < count; ++k) {
    const int x = static_cast<int>(std::lround(views[k].x));
    const int y = static_cast<int>(std::lround(views[k].y));
    sum += raw.gain_slope_x(x, y) * views[k].dx + raw.gain_slope_y(x, y) * views[k].dy;
  }
  return 0.5f * smooth_noise * smooth_noise * sum * (1 - 1 / static_cast<float>(count));
}

// Points the samples at the patches around the views.
void PlaceSamples(const PreparedRaw& raw,
                  const LensTable& lenses,
                  const DefocusMatch& match,
                  const LensView* views,
                  int count,
                  PatchSample* samples) {
  for (int k = 0; k < count; ++k) {
    const LensView& view = views[k];
    const Lens& lens = lenses.lenses()[view.lens];
    const float x = view.x - kPatchRadius;
    const float y = view.y - kPatchRadius;
    const float blend = match.Blend(lens.type);
    const ImageF& colours = blend > 0 ? raw.lens_colour_smoother : raw.lens_colour;
    samples[k] = {raw.smooth.At(x, y),
                  blend > 0 ? raw.smoother.At(x, y) : HalfPixelImage::Cell{},
                  blend,
                  colours.row(static_cast<int>(y)) + static_cast<int>(x),
                  view.dx,
                  view.dy,
                  static_cast<float>(lens.colour + 1)};
  }
}

}  // namespace

bool DepthOptions::IsValid(std::string* error) const {
  if (!(min_inverse_virtual_depth > 0 && min_inverse_virtual_depth < max_inverse_virtual_depth &&
        max_inverse_virtual_depth <= 0.5)) {
    *error = "search range of 1/v from " + std::to_string(min_inverse_virtual_depth) + " to " +
             std::to_string(max_inverse_virtual_depth) + ", expected 0 < min < max <= 0.5";
  } else if (!(search_step * (kMaxHypotheses - 1) >=
               max_inverse_virtual_depth - min_inverse_virtual_depth)) {
    *error = "search_step of " + std::to_string(search_step) + ", expected at most 63 steps";
  } else if (!(seed_spacing >= 1 && seed_spacing <= 8)) {
    *error = "seed_spacing of " + std::to_string(seed_spacing) + ", expected 1 to 8";
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
      block_width_((camera.raw_width + kBlock - 1) / kBlock),
      seed_width_((width_ + options.seed_spacing - 1) / options.seed_spacing),
      seed_height_((height_ + options.seed_spacing - 1) / options.seed_spacing) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
  textured_.resize(static_cast<size_t>(block_width_) * ((camera.raw_height + kBlock - 1) / kBlock));
  seeds_.resize(static_cast<size_t>(seed_width_) * seed_height_);
  raw_depth_ = ImageF(width_, height_);
  raw_sigma_ = ImageF(width_, height_);
}

void DepthEstimator::MeasureTexture(const PreparedRaw& raw) {
  // gray - smooth of white noise has 0.8 of its standard deviation; the median absolute value of a
  // Gaussian is 0.6745 of it.
  std::array<int, 1024> histogram{};
  int total = 0;
  const ImageF& smooth = raw.smooth.phase[0][0];
  const int height = raw.gray.height();
  const int width = raw.gray.width();
  for (int y = 1; y < height - 1; y += 5) {
    for (int x = 1; x < width - 1; ++x) {
      if (raw.lens_colour(x, y) == 0) continue;
      const float difference = std::abs(raw.gray(x, y) - smooth(x, y));
      if (difference == 0) continue;  // not filtered
      ++histogram[std::min(static_cast<int>(difference * 32), 1023)];
      ++total;
    }
  }
  int bin = 0;
  for (int seen = histogram[0]; bin < 1023 && 2 * seen < total; seen += histogram[++bin]) {
  }
  const double noise = raw.mosaic_noise > 0 ? raw.mosaic_noise : (bin + 0.5) / 32 / (0.8 * 0.6745);
  noise_ = std::max(noise, 0.3);

  const float threshold = static_cast<float>(options_.min_gradient * noise_ * kSmoothNoise);
  const float threshold_squared = threshold * threshold;
  const int block_height = static_cast<int>(textured_.size()) / block_width_;
  tbb::parallel_for(0, block_height, [&](int by) {
    for (int bx = 0; bx < block_width_; ++bx) {
      int count = 0;
      for (int y = by * kBlock; y < std::min((by + 1) * kBlock, height - 1); ++y) {
        const float* row = smooth.row(y);
        const float* below = smooth.row(y + 1);
        const float* colour = raw.lens_colour.row(y);
        for (int x = bx * kBlock; x < std::min((bx + 1) * kBlock, width - 1); ++x) {
          const float dx = row[x + 1] - row[x];
          const float dy = below[x] - row[x];
          count += colour[x] != 0 && dx * dx + dy * dy > threshold_squared;
        }
      }
      textured_[static_cast<size_t>(by) * block_width_ + bx] =
          static_cast<uint8_t>(std::min(count, 255));
    }
  });
}

DepthEstimator::Estimated DepthEstimator::Refine(
    const PreparedRaw& raw, float X, float Y, float w, int iterations) const {
  LensView views[LensTable::kMaxViews];
  Samples samples;
  const float noise = static_cast<float>(noise_) * kSmoothNoise;
  const DefocusMatch match(lenses_.focus_of_type(), lenses_.DefocusVariance(), w);
  const int seen = lenses_.ViewsOf(X, Y, w, lenses_.radius_px() - 1, kMargin, views);
  const int count = SelectViews(lenses_, match, kMaxComparedViews, seen, views);
  if (count < 2) return {};
  const float start = w;
  const float max_step = static_cast<float>(options_.search_step);
  const float* colours[LensTable::kMaxViews];
  PatchSums sums{};
  float cost = 0;
  for (int iteration = 1;; ++iteration) {
    PlaceSamples(raw, lenses_, match, views, count, samples.data());
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
      if (!raw.gray.view().Contains(views[k].x, views[k].y, kMargin)) return {};
    }
  }
  if (!(w >= options_.min_inverse_virtual_depth && w <= options_.max_inverse_virtual_depth) ||
      sums.freedom < 4) {
    return {};
  }
  const float gray_noise = static_cast<float>(noise_);
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
  for (const Estimated& seed : seeds_) {
    if (seed.w > 0) samples.push_back({seed.contrast, seed.residual});
  }
  misfit_ = FitMisfit(std::move(samples));
  for (Estimated& seed : seeds_) {
    if (seed.w > 0 && !Accept(&seed)) seed = {};
  }
}

DepthEstimator::Estimated DepthEstimator::Search(const PreparedRaw& raw, float X, float Y) const {
  LensView views[LensTable::kMaxViews];
  Samples samples;
  const float min_w = static_cast<float>(options_.min_inverse_virtual_depth);
  const float step = static_cast<float>(options_.search_step);
  const int count_w =
      1 + static_cast<int>(std::floor((options_.max_inverse_virtual_depth - min_w) / step));
  const float middle = 0.3f;
  if (lenses_.ViewsOf(X, Y, middle, lenses_.radius_px(), kMargin, views) == 0) return {};
  const int bx = static_cast<int>(views[0].x) / kBlock;
  const int by = static_cast<int>(views[0].y) / kBlock;
  int texture = 0;
  for (int y = std::max(by - 1, 0); y <= by + 1; ++y) {
    for (int x = std::max(bx - 1, 0); x <= std::min(bx + 1, block_width_ - 1); ++x) {
      const size_t block = static_cast<size_t>(y) * block_width_ + x;
      if (block < textured_.size()) texture += textured_[block];
    }
  }
  if (texture < 8) return {};

  const float noise = static_cast<float>(noise_) * kSmoothNoise;
  std::array<float, kMaxHypotheses> cost;
  std::array<float, kMaxHypotheses> freedom;
  int best = -1;
  for (int h = 0; h < count_w; ++h) {
    const float w = min_w + step * static_cast<float>(h);
    cost[h] = 1e30f;
    const DefocusMatch match(lenses_.focus_of_type(), lenses_.DefocusVariance(), w);
    const int seen = lenses_.ViewsOf(X, Y, w, lenses_.radius_px() - 2, kMargin, views);
    const int count = SelectViews(lenses_, match, kMaxSearched, seen, views);
    if (count < 2) continue;
    PlaceSamples(raw, lenses_, match, views, count, samples.data());
    const PatchSums sums = SumPatchCosts(samples.data(), count, raw.gray.width());
    if (sums.freedom < 4) continue;
    cost[h] = sums.cost / sums.freedom;
    freedom[h] = sums.freedom;
    if (best < 0 || cost[h] < cost[best]) best = h;
  }
  // Fewer lenses see a point the larger its 1/v: a minimum must be bracketed, or the best one may
  // lie where there is nothing to compare.
  if (best <= 0 || best + 1 >= count_w || cost[best - 1] > 1e29f || cost[best + 1] > 1e29f) {
    return {};
  }
  // A second minimum nearly as low, away from the first, makes the match ambiguous.
  const float scale = std::max(cost[best], noise * noise);
  const float ambiguity = static_cast<float>(options_.ambiguity);
  for (int h = 0; h < count_w; ++h) {
    if (std::abs(h - best) <= 2 || cost[h] > 1e29f) continue;
    if (freedom[h] * (cost[h] - cost[best]) < ambiguity * scale) return {};
  }
  // From the vertex of the parabola through the three costs: started from a grid value, what is
  // refined would depend on which one was near.
  const float below = cost[best - 1] - cost[best];
  const float above = cost[best + 1] - cost[best];
  const float vertex = static_cast<float>(best) +
                       (below + above > 0 ? 0.5f * (below - above) / (below + above) : 0.0f);
  return Refine(raw, X, Y, min_w + step * vertex, 6);
}

DepthEstimator::Estimated DepthEstimator::RefineFromSeeds(const PreparedRaw& raw,
                                                          int x,
                                                          int y) const {
  const int spacing = options_.seed_spacing;
  const int sx = x / spacing;
  const int sy = y / spacing;
  const float X = (static_cast<float>(x) + 0.5f) * static_cast<float>(scale_) - 0.5f;
  const float Y = (static_cast<float>(y) + 0.5f) * static_cast<float>(scale_) - 0.5f;
  // The seeds that agree with the most certain one around, and the most certain that disagrees.
  const Estimated* first = nullptr;
  const Estimated* second = nullptr;
  float sum = 0;
  int agree = 0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int j = std::max(sy - 1, 0); j <= std::min(sy + 1, seed_height_ - 1); ++j) {
      for (int i = std::max(sx - 1, 0); i <= std::min(sx + 1, seed_width_ - 1); ++i) {
        const Estimated& seed = seeds_[static_cast<size_t>(j) * seed_width_ + i];
        if (seed.w == 0) continue;
        if (pass == 0) {
          if (!first || seed.sigma < first->sigma) first = &seed;
        } else if (std::abs(seed.w - first->w) <= 0.02f) {
          sum += seed.w;
          ++agree;
        } else if (!second || seed.sigma < second->sigma) {
          second = &seed;
        }
      }
    }
    if (!first) return {};
  }
  // The mean of several depends less on the noise of this patch, which is that of its nearest seed.
  Estimated result = Refine(raw, X, Y, sum / static_cast<float>(agree), 3);
  if (second) {
    const Estimated other = Refine(raw, X, Y, second->w, 3);
    if (other.w > 0 && (result.w == 0 || other.residual < result.residual)) result = other;
  }
  return result.w > 0 && Accept(&result) ? result : Estimated();
}

void DepthEstimator::Estimate(const PreparedRaw& raw,
                              ImageF* inverse_virtual_depth,
                              ImageF* sigma) {
  MeasureTexture(raw);
  const int spacing = options_.seed_spacing;
  tbb::parallel_for(0, seed_height_, [&](int j) {
    for (int i = 0; i < seed_width_; ++i) {
      const float x = static_cast<float>(i * spacing + spacing / 2);
      const float y = static_cast<float>(j * spacing + spacing / 2);
      const float scale = static_cast<float>(scale_);
      seeds_[static_cast<size_t>(j) * seed_width_ + i] =
          Search(raw, (x + 0.5f) * scale - 0.5f, (y + 0.5f) * scale - 0.5f);
    }
  });
  AcceptSeeds();
  tbb::parallel_for(0, height_, [&](int y) {
    for (int x = y % 2; x < width_; x += 2) {
      const Estimated estimated = RefineFromSeeds(raw, x, y);
      raw_depth_(x, y) = estimated.w;
      raw_sigma_(x, y) = estimated.sigma;
    }
  });
  FillBetween(&raw_depth_, &raw_sigma_);
  FuseNeighbours(raw_depth_, raw_sigma_, inverse_virtual_depth, sigma);
}

}  // namespace prism
