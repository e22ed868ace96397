// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_conditions.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <glog/logging.h>

#include "prism/camera/projection.h"
#include "prism/image/interpolation.h"
#include "prism/lightfield/defocus_match.h"
#include "prism/lightfield/half_pixel_image.h"
#include "prism/lightfield/patch_kernel.h"

namespace prism {
namespace {

constexpr double kEdge = 0.01;       // of 1/v between neighbours
constexpr int kEdgeReach = 30;       // focused px
constexpr int kSlantBaseline = 3;    // focused px to either side
constexpr float kMargin = 4;         // raw px between views and the image border
constexpr int kMinPatchPixels = 25;  // of 49, fewer say nothing of a correlation
constexpr double kLagStep = 0.5;     // raw px
constexpr double kMinCorrelation = 0.5;
constexpr double kMinDip = 0.2;  // of the correlation before its second maximum

// 1 on the near side of a depth edge, -1 on its far side, 0 elsewhere. Near is a smaller 1/v in a
// Galilean camera, a larger one in a Keplerian camera.
Image<int8_t> FindDepthEdges(const ImageF& truth, MicroLensMode mode) {
  const int8_t side_of_larger = mode == MicroLensMode::kKeplerian ? 1 : -1;
  Image<int8_t> edges(truth.width(), truth.height());
  for (int y = 1; y < truth.height() - 1; ++y) {
    for (int x = 1; x < truth.width() - 1; ++x) {
      const float w = truth(x, y);
      if (w == 0) continue;
      double largest = 0;
      for (const float other :
           {truth(x - 1, y), truth(x + 1, y), truth(x, y - 1), truth(x, y + 1)}) {
        const double step = other - w;
        if (other != 0 && std::abs(step) > std::abs(largest)) largest = step;
      }
      if (std::abs(largest) > kEdge) edges(x, y) = largest > 0 ? -side_of_larger : side_of_larger;
    }
  }
  return edges;
}

// The edge runs half a pixel beside the pixels next to it.
double DepthEdgeDistance(const Image<int8_t>& edges, const Eigen::Vector2i& px) {
  int nearest = kEdgeReach * kEdgeReach + 1;
  int side = 0;
  for (int y = std::max(px.y() - kEdgeReach, 0);
       y <= std::min(px.y() + kEdgeReach, edges.height() - 1);
       ++y) {
    for (int x = std::max(px.x() - kEdgeReach, 0);
         x <= std::min(px.x() + kEdgeReach, edges.width() - 1);
         ++x) {
      const int squared = (Eigen::Vector2i(x, y) - px).squaredNorm();
      if (edges(x, y) == 0 || squared >= nearest) continue;
      nearest = squared;
      side = edges(x, y);
    }
  }
  return side == 0 ? NAN : side * (std::sqrt(nearest) + 0.5);
}

double Slant(const ImageF& truth, const Eigen::Vector2i& px) {
  if (!truth.view().Contains(px.x(), px.y(), kSlantBaseline)) return NAN;
  const int x = px.x();
  const int y = px.y();
  const float left = truth(x - kSlantBaseline, y);
  const float right = truth(x + kSlantBaseline, y);
  const float above = truth(x, y - kSlantBaseline);
  const float below = truth(x, y + kSlantBaseline);
  if (left == 0 || right == 0 || above == 0 || below == 0) return NAN;
  return std::hypot(right - left, below - above) / (2 * kSlantBaseline);
}

// Unit vectors from a lens to its nearest neighbours.
std::vector<Eigen::Vector2d> LensAxes(const LensTable& lenses) {
  const int middle = lenses.NearestLens(0.5f * static_cast<float>(lenses.width()),
                                        0.5f * static_cast<float>(lenses.height()));
  CHECK_GE(middle, 0);
  const auto center = [&](int lens) {
    return Eigen::Vector2d(lenses.lenses()[lens].center_x, lenses.lenses()[lens].center_y);
  };
  std::vector<Eigen::Vector2d> axes;
  for (const int lens : lenses.NeighboursOf(middle, 1.2f * lenses.pitch_px())) {
    axes.push_back((center(lens) - center(middle)).normalized());
  }
  return axes;
}

double LensAxisAngleDeg(const std::vector<Eigen::Vector2d>& axes, const Eigen::Vector2d& gradient) {
  if (gradient.isZero(0)) return NAN;
  double cosine = 0;
  for (const Eigen::Vector2d& axis : axes) {
    cosine = std::max(cosine, std::abs(axis.dot(gradient.normalized())));
  }
  return std::acos(std::min(cosine, 1.0)) * 180 / M_PI;
}

// What texture is looked for in.
struct SmoothRaw {
  const Image<uint8_t>& lens_colour;
  ImageF image;
};

std::optional<double> SampleMicroImage(const SmoothRaw& raw, int colour, double x, double y) {
  if (!raw.image.view().Contains(x, y, 1) ||
      raw.lens_colour(static_cast<int>(x), static_cast<int>(y)) != colour + 1) {
    return std::nullopt;
  }
  return InterpolateBilinear(raw.image, x, y).value;
}

// Normalised correlation of the patches half of `lag` to either side of a view, where both lie in
// its micro image; nothing if that is too little, 0 if there is no texture above the noise.
std::optional<double> SelfCorrelation(const SmoothRaw& raw,
                                      int colour,
                                      const Eigen::Vector2d& view,
                                      const Eigen::Vector2d& lag,
                                      double noise) {
  int count = 0;
  double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
  for (int dy = -kPatchRadius; dy <= kPatchRadius; ++dy) {
    for (int dx = -kPatchRadius; dx <= kPatchRadius; ++dx) {
      const Eigen::Vector2d at = view + Eigen::Vector2d(dx, dy);
      const Eigen::Vector2d at_a = at - 0.5 * lag;
      const Eigen::Vector2d at_b = at + 0.5 * lag;
      const std::optional<double> a = SampleMicroImage(raw, colour, at_a.x(), at_a.y());
      const std::optional<double> b = SampleMicroImage(raw, colour, at_b.x(), at_b.y());
      if (!a || !b) continue;
      ++count;
      sum_a += *a;
      sum_b += *b;
      sum_aa += *a * *a;
      sum_bb += *b * *b;
      sum_ab += *a * *b;
    }
  }
  if (count < kMinPatchPixels) return std::nullopt;
  const double variance_a = (sum_aa - sum_a * sum_a / count) / count;
  const double variance_b = (sum_bb - sum_b * sum_b / count) / count;
  if (std::min(variance_a, variance_b) < noise * noise) return 0;
  return (sum_ab - sum_a * sum_b / count) / count / std::sqrt(variance_a * variance_b);
}

// Lag of the first maximum after a dip; NaN if there is none up to `max_lag`.
double TexturePeriod(const SmoothRaw& raw,
                     int colour,
                     const Eigen::Vector2d& view,
                     const Eigen::Vector2d& axis,
                     double max_lag,
                     double noise) {
  double lowest = 1;
  double before = 1;
  bool rises = false;
  for (double lag = kLagStep; lag <= max_lag; lag += kLagStep) {
    const std::optional<double> now = SelfCorrelation(raw, colour, view, lag * axis, noise);
    if (!now) break;
    if (rises && *now < before && before > kMinCorrelation && before - lowest >= kMinDip) {
      return lag - kLagStep;
    }
    rises = *now > before;
    before = *now;
    lowest = std::min(lowest, before);
  }
  return NAN;
}

// The views that are compared, nearest to the chief ray first.
std::vector<LensView> ComparedViews(const LensTable& lenses,
                                    const DefocusMatch& match,
                                    const Eigen::Vector2d& raw_px,
                                    double w) {
  LensView views[LensTable::kMaxViews];
  const int count = lenses.ViewsOf(static_cast<float>(raw_px.x()),
                                   static_cast<float>(raw_px.y()),
                                   static_cast<float>(w),
                                   lenses.radius_px() - 1,
                                   kMargin,
                                   match.types(),
                                   kMaxComparedViews,
                                   views);
  return {views, views + count};
}

void MeasureViews(const LightFieldProcessor& processor,
                  const SmoothRaw& raw,
                  const std::vector<Eigen::Vector2d>& axes,
                  const Eigen::Vector2d& raw_px,
                  DepthConditions* conditions) {
  const LensTable& lenses = processor.lenses();
  const double w = conditions->true_inverse_virtual_depth;
  const std::vector<float>& focus = lenses.focus_of_type();
  const DefocusMatch match(focus, lenses.DefocusVariance(), static_cast<float>(w));
  const auto nearest = std::min_element(focus.begin(), focus.end(), [&](float a, float b) {
    return std::abs(a - w) < std::abs(b - w);
  });
  conditions->sharpest_type = static_cast<int>(nearest - focus.begin());
  for (int type = 0; type < static_cast<int>(focus.size()); ++type) {
    conditions->types_used |= match.Uses(type) ? 1 << type : 0;
  }
  const std::vector<LensView> views = ComparedViews(lenses, match, raw_px, w);
  if (views.empty()) return;
  double sum = 0;
  for (const LensView& view : views) sum += view.radius_px;
  conditions->view_radius_px = sum / static_cast<double>(views.size());
  conditions->chief_view_radius_px = views[0].radius_px;
  for (const Eigen::Vector2d& axis : axes) {
    const double period = TexturePeriod(raw,
                                        lenses.lenses()[views[0].lens].colour,
                                        {views[0].x, views[0].y},
                                        axis,
                                        0.5 * lenses.pitch_px(),
                                        processor.noise());
    conditions->texture_period_px = std::fmin(conditions->texture_period_px, period);
  }
}

}  // namespace

std::vector<DepthConditions> MeasureDepthConditions(const LightFieldProcessor& processor,
                                                    const LightFieldFrame& frame,
                                                    const ImageF& truth,
                                                    const std::vector<Eigen::Vector2i>& pixels) {
  const PlenopticProjection projection(processor.camera());
  const ImageF& image = frame.image[0];
  const std::vector<Eigen::Vector2d> axes = LensAxes(processor.lenses());
  const Image<int8_t> edges = FindDepthEdges(truth, processor.camera().mode);
  const Eigen::Vector2d center(0.5 * (image.width() - 1), 0.5 * (image.height() - 1));
  const PreparedRaw& prepared = processor.prepared();
  const SmoothRaw raw{prepared.lens_colour, FilterWholePixels(prepared.gray)};
  std::vector<DepthConditions> result;
  for (const Eigen::Vector2i& px : pixels) {
    const int x = px.x();
    const int y = px.y();
    CHECK(image.view().Contains(x, y, 1) && truth(x, y) > 0) << px.transpose();
    const Eigen::Vector2d gradient(0.5 * (image(x + 1, y) - image(x - 1, y)),
                                   0.5 * (image(x, y + 1) - image(x, y - 1)));
    DepthConditions conditions;
    conditions.true_inverse_virtual_depth = truth(x, y);
    const double rho = InverseDepth(projection, truth(x, y));
    conditions.distance_m = rho > 0 ? 1 / rho : INFINITY;
    conditions.contrast = gradient.norm() / processor.noise();
    conditions.lens_axis_angle_deg = LensAxisAngleDeg(axes, gradient);
    conditions.depth_edge_distance_px = DepthEdgeDistance(edges, px);
    conditions.image_radius_px = (px.cast<double>() - center).norm();
    MeasureViews(
        processor, raw, axes, RawFromFocused(processor.camera(), px.cast<double>()), &conditions);
    if (!(std::abs(conditions.depth_edge_distance_px) < kSlantBaseline + 0.5)) {
      conditions.slant = Slant(truth, px);
    }
    result.push_back(conditions);
  }
  return result;
}

}  // namespace prism
