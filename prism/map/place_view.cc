// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_view.h"

#include <algorithm>
#include <cmath>

#include <glog/logging.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/statistics.h"
#include "prism/map/place_features.h"

namespace prism {
namespace {

constexpr int kPyramidLevels = 6;
constexpr int kJpegQuality = 95;  // errors below the noise of images

}  // namespace

Place MakePlace(const PlenopticProjection& camera,
                int keyframe_id,
                const LightFieldFrame& frame,
                const std::vector<ReferencePoint>& points) {
  Place place;
  place.keyframe_id = keyframe_id;
  CHECK(cv::imencode(
      ".jpg", RoundedImage(frame.image[0]), place.image, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}));
  for (const ReferencePoint& point : points) {
    place.points.push_back({static_cast<float>(point.px.x()),
                            static_cast<float>(point.px.y()),
                            static_cast<float>(point.rho),
                            static_cast<float>(point.rho_sigma)});
  }
  place.median_rho = static_cast<float>(MedianInverseDepth(points));
  DetectFeatures(camera, frame, &place);
  return place;
}

std::vector<ReferencePoint> MeasuredPoints(const PlenopticProjection& camera,
                                           const LightFieldFrame& frame,
                                           int count,
                                           const PointSelectionOptions& options) {
  const auto is_measured = [&](int x, int y) { return frame.sigma(x, y) > 0; };
  std::vector<ReferencePoint> points;
  for (const Eigen::Vector2i& px :
       SelectPoints(SquaredGradientMagnitude(frame.image[0]), count, is_measured, options)) {
    const double w = frame.inverse_virtual_depth(px.x(), px.y());
    const double sigma = frame.sigma(px.x(), px.y());
    ReferencePoint point;
    point.px = px.cast<double>();
    point.rho = std::max(InverseDepth(camera, w), 0.0);
    point.rho_sigma = std::sqrt(InverseDepthVariance(camera, w, sigma * sigma));
    if (point.rho * camera.f < 1) points.push_back(point);
  }
  return points;
}

double MedianInverseDepth(const std::vector<ReferencePoint>& points) {
  std::vector<double> rho;
  for (const ReferencePoint& point : points) rho.push_back(point.rho);
  return Quantile(std::move(rho), 0.5);
}

PlaceView MakePlaceView(const PlenopticCamera& camera, const Place& place) {
  const cv::Mat decoded = cv::imdecode(place.image, cv::IMREAD_GRAYSCALE);
  CHECK(!decoded.empty()) << "the image of place " << place.keyframe_id << " does not decode";
  ImageF image(decoded.cols, decoded.rows);
  decoded.convertTo(cv::Mat(decoded.rows, decoded.cols, CV_32FC1, image.data()), CV_32F);
  std::vector<ReferencePoint> points;
  for (const Place::Point& point : place.points) {
    ReferencePoint reference;
    reference.px = {point.x, point.y};
    reference.rho = point.rho;
    reference.rho_sigma = point.rho_sigma;
    points.push_back(reference);
  }
  PlaceView view;
  view.image = BuildPyramid(std::move(image), kPyramidLevels);
  view.reference = MakeTrackingReference(camera, view.image, points);
  return view;
}

}  // namespace prism
