// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "prism/base/statistics.h"
#include "prism/tracking/reference_points.h"

namespace prism {
namespace {

constexpr int kPointDistance = 6;  // px, of added points from those that are there
constexpr double kMaxSigmas = 3;
constexpr double kMinSigma = 1e-4;  // of 1/v

// A mask of the size of `image`; not 0: a point is near.
cv::Mat1b AreasNear(const std::vector<ReferencePoint>& points, const ImageF& image) {
  cv::Mat1b near(image.height(), image.width(), uint8_t{0});
  for (const ReferencePoint& point : points) {
    cv::circle(near, cv::Point2d(point.px.x(), point.px.y()), kPointDistance, 1, cv::FILLED);
  }
  return near;
}

// The 1/v a frame should measure at a point.
struct ExpectedDepth {
  int x = 0;
  int y = 0;
  double w = 0;
  double sigma = 0;

  ExpectedDepth(const PlenopticProjection& camera, const ReferencePoint& point, double depth_offset)
      : x(static_cast<int>(std::lround(point.px.x()))),
        y(static_cast<int>(std::lround(point.px.y()))) {
    double dw_drho = 0;
    w = InverseVirtualDepth(camera, point.rho, &dw_drho) + depth_offset;
    sigma = std::max(std::abs(dw_drho) * point.rho_sigma, kMinSigma);
  }

  bool IsContradictedAt(const LightFieldFrame& frame, int u, int v) const {
    return frame.sigma(u, v) > 0 && std::abs(frame.inverse_virtual_depth(u, v) - w) >
                                        kMaxSigmas * std::hypot(frame.sigma(u, v), sigma);
  }
};

}  // namespace

std::vector<ReferencePoint> PointsOf(const Place& place) {
  std::vector<ReferencePoint> points;
  for (const Place::Point& point : place.points) {
    ReferencePoint reference;
    reference.px = {point.x, point.y};
    reference.rho = point.rho;
    reference.rho_sigma = point.rho_sigma;
    points.push_back(reference);
  }
  return points;
}

std::vector<ReferencePoint> PointsSeenFrom(const PlenopticProjection& camera,
                                           const Place& place,
                                           const SE3& frame_from_place) {
  const RigidMotion motion(frame_from_place);
  std::vector<ReferencePoint> seen;
  for (const ReferencePoint& point : PointsOf(place)) {
    if (const auto moved = TransferPoint(camera, motion, point)) seen.push_back(*moved);
  }
  return seen;
}

double MedianInverseDepth(const std::vector<ReferencePoint>& points) {
  std::vector<double> rho;
  for (const ReferencePoint& point : points) rho.push_back(point.rho);
  return Quantile(std::move(rho), 0.5);
}

void AddSeenPoints(const PlenopticProjection& camera,
                   const LightFieldFrame& frame,
                   double depth_offset,
                   const std::vector<ReferencePoint>& seen,
                   std::vector<ReferencePoint>* points) {
  const cv::Mat1b near = AreasNear(*points, frame.sigma);
  for (const ReferencePoint& point : seen) {
    if (!frame.sigma.view().Contains(point.px.x(), point.px.y(), 1)) continue;
    const ExpectedDepth expected(camera, point, depth_offset);
    if (near(expected.y, expected.x) == 0 &&
        !expected.IsContradictedAt(frame, expected.x, expected.y)) {
      points->push_back(point);
    }
  }
}

void AddMeasuredPoints(const PlenopticProjection& camera,
                       const LightFieldFrame& frame,
                       double depth_offset,
                       int count,
                       const PointSelectionOptions& options,
                       std::vector<ReferencePoint>* points) {
  const int missing = count - static_cast<int>(points->size());
  if (missing <= 0) return;
  const cv::Mat1b near = AreasNear(*points, frame.sigma);
  const auto is_usable = [&](int x, int y) { return frame.sigma(x, y) > 0 && near(y, x) == 0; };
  for (const Eigen::Vector2i& px :
       SelectPoints(SquaredGradientMagnitude(frame.image[0]), missing, is_usable, options)) {
    const double w = frame.inverse_virtual_depth(px.x(), px.y()) - depth_offset;
    const double sigma = frame.sigma(px.x(), px.y());
    ReferencePoint point;
    point.px = px.cast<double>();
    point.rho = std::max(InverseDepth(camera, w), 0.0);
    point.rho_sigma = std::sqrt(InverseDepthVariance(camera, w, sigma * sigma));
    if (point.rho * camera.f < 1) points->push_back(point);
  }
}

LightFieldFrame WithKnownDepths(const PlenopticProjection& camera,
                                LightFieldFrame frame,
                                double depth_offset,
                                const std::vector<ReferencePoint>& seen) {
  for (const ReferencePoint& point : seen) {
    if (!frame.sigma.view().Contains(point.px.x(), point.px.y(), 2)) continue;
    const ExpectedDepth expected(camera, point, depth_offset);
    for (int v = expected.y - 1; v <= expected.y + 1; ++v) {
      for (int u = expected.x - 1; u <= expected.x + 1; ++u) {
        float& sigma = frame.sigma(u, v);
        if (expected.IsContradictedAt(frame, u, v) || (sigma > 0 && sigma < expected.sigma)) {
          continue;
        }
        frame.inverse_virtual_depth(u, v) = static_cast<float>(expected.w);
        sigma = static_cast<float>(expected.sigma);
      }
    }
  }
  return frame;
}

}  // namespace prism
