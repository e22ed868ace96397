// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_view.h"

#include <glog/logging.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/map/place_features.h"
#include "prism/map/place_points.h"

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

PlaceView MakePlaceView(const PlenopticCamera& camera, const Place& place) {
  const cv::Mat decoded = cv::imdecode(place.image, cv::IMREAD_GRAYSCALE);
  CHECK(!decoded.empty()) << "the image of place " << place.keyframe_id << " does not decode";
  ImageF image(decoded.cols, decoded.rows);
  decoded.convertTo(cv::Mat(decoded.rows, decoded.cols, CV_32FC1, image.data()), CV_32F);
  PlaceView view;
  view.image = BuildPyramid(std::move(image), kPyramidLevels);
  view.reference = MakeTrackingReference(camera, view.image, PointsOf(place));
  return view;
}

}  // namespace prism
