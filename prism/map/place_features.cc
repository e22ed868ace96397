// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_features.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

namespace prism {
namespace {

constexpr int kNumFeatures = 500;
constexpr int kMaxWidth = 700;  // px of the level features are found on; finer ones are noise
constexpr int kFastThreshold = 7;
constexpr float kMaxRatio = 0.85F;  // of the distances of the best and the second-best match
constexpr double kMaxError = 0.01;  // of the image width, reprojection of an inlier
constexpr int kRansacIterations = 300;

// 1/m measured at a pixel or near it, by the most certain pixel; 0: nowhere.
float MeasuredInverseDepth(const PlenopticProjection& camera,
                           const LightFieldFrame& frame,
                           const Eigen::Vector2d& px) {
  constexpr int kRadius = 3;  // px
  float best_sigma = INFINITY, w = 0;
  const int x = static_cast<int>(std::lround(px.x())), y = static_cast<int>(std::lround(px.y()));
  for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, frame.sigma.height() - 1);
       ++v) {
    for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, frame.sigma.width() - 1);
         ++u) {
      if (frame.sigma(u, v) > 0 && frame.sigma(u, v) < best_sigma) {
        best_sigma = frame.sigma(u, v);
        w = frame.inverse_virtual_depth(u, v);
      }
    }
  }
  if (std::isinf(best_sigma)) return 0;
  const double rho = InverseDepth(camera, w);
  return rho * camera.f < 1 ? static_cast<float>(std::max(rho, 1e-3)) : 0;
}

}  // namespace

cv::Mat RoundedImage(const ImageF& image) {
  cv::Mat rounded;
  cv::Mat(image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data()))
      .convertTo(rounded, CV_8U);
  return rounded;
}

void DetectFeatures(const PlenopticProjection& camera, const LightFieldFrame& frame, Place* place) {
  size_t level = 0;
  while (level + 1 < frame.image.size() && frame.image[level].width() > kMaxWidth) ++level;
  const auto orb =
      cv::ORB::create(kNumFeatures, 1.2F, 6, 19, 0, 2, cv::ORB::HARRIS_SCORE, 31, kFastThreshold);
  std::vector<cv::KeyPoint> keypoints;
  orb->detectAndCompute(
      RoundedImage(frame.image[level]), cv::noArray(), keypoints, place->descriptors);
  const double scale = std::ldexp(1.0, static_cast<int>(level));
  for (const cv::KeyPoint& keypoint : keypoints) {
    const Eigen::Vector2d px = {(keypoint.pt.x + 0.5) * scale - 0.5,
                                (keypoint.pt.y + 0.5) * scale - 0.5};
    place->features.push_back({static_cast<float>(px.x()),
                               static_cast<float>(px.y()),
                               MeasuredInverseDepth(camera, frame, px)});
  }
}

std::vector<FeatureMatch> MatchFeatures(const Place& query, const Place& known) {
  std::vector<FeatureMatch> matches;
  if (query.descriptors.rows < 2 || known.descriptors.rows < 2) return matches;
  const cv::BFMatcher matcher(cv::NORM_HAMMING);
  std::vector<std::vector<cv::DMatch>> candidates;
  matcher.knnMatch(query.descriptors, known.descriptors, candidates, 2);
  std::vector<int> best_query(known.features.size(), -1);
  std::vector<float> best_distance(known.features.size(), INFINITY);
  for (const std::vector<cv::DMatch>& best : candidates) {
    if (best.size() < 2 || best[0].distance > kMaxRatio * best[1].distance) continue;
    const int known_index = best[0].trainIdx;
    if (best[0].distance >= best_distance[known_index]) continue;
    best_distance[known_index] = best[0].distance;
    best_query[known_index] = best[0].queryIdx;
  }
  for (size_t i = 0; i < best_query.size(); ++i) {
    if (best_query[i] >= 0) matches.push_back({best_query[i], static_cast<int>(i)});
  }
  return matches;
}

std::optional<FeaturePose> EstimateFeaturePose(const PlenopticProjection& camera,
                                               const Place& query,
                                               const Place& known,
                                               const std::vector<FeatureMatch>& matches,
                                               int min_inliers) {
  std::vector<cv::Point3d> points;  // about the centre of projection
  std::vector<cv::Point2d> pixels;
  for (const FeatureMatch& match : matches) {
    const Place::Feature& feature = known.features[match.known];
    if (feature.rho <= 0) continue;
    const Eigen::Vector3d p_in_cam =
        UnprojectInverseDepth(camera, Eigen::Vector2d(feature.x, feature.y), feature.rho);
    points.emplace_back(p_in_cam.x(), p_in_cam.y(), p_in_cam.z() - camera.center_z());
    pixels.emplace_back(query.features[match.query].x, query.features[match.query].y);
  }
  if (static_cast<int>(points.size()) < std::max(min_inliers, 4)) return std::nullopt;
  const double f_px = camera.FocalLengthPx();
  const cv::Matx33d K(f_px, 0, camera.c.x(), 0, f_px, camera.c.y(), 0, 0, 1);
  cv::Mat rotation_vector, translation, inliers;
  if (!cv::solvePnPRansac(points,
                          pixels,
                          K,
                          cv::noArray(),
                          rotation_vector,
                          translation,
                          false,
                          kRansacIterations,
                          static_cast<float>(kMaxError * camera.width),
                          0.999,
                          inliers,
                          cv::SOLVEPNP_AP3P) ||
      inliers.rows < min_inliers) {
    return std::nullopt;
  }
  // solvePnPRansac ends with EPnP, which is lost where all points lie near a plane.
  std::vector<cv::Point3d> points_agreeing;
  std::vector<cv::Point2d> pixels_agreeing;
  for (int i = 0; i < inliers.rows; ++i) {
    points_agreeing.push_back(points[inliers.at<int>(i)]);
    pixels_agreeing.push_back(pixels[inliers.at<int>(i)]);
  }
  if (!cv::solvePnP(points_agreeing,
                    pixels_agreeing,
                    K,
                    cv::noArray(),
                    rotation_vector,
                    translation,
                    false,
                    cv::SOLVEPNP_SQPNP)) {
    return std::nullopt;
  }
  cv::solvePnPRefineLM(
      points_agreeing, pixels_agreeing, K, cv::noArray(), rotation_vector, translation);
  Vector6d turn = Vector6d::Zero();
  Eigen::Vector3d t;
  for (int i = 0; i < 3; ++i) {
    turn[3 + i] = rotation_vector.at<double>(i);
    t[i] = translation.at<double>(i);
  }
  if (!turn.allFinite() || !t.allFinite()) return std::nullopt;
  const SE3 rotation = SE3::Exp(turn);
  const SE3 cam_from_center(Eigen::Quaterniond::Identity(), {0, 0, camera.center_z()});
  FeaturePose pose;
  pose.query_from_known = cam_from_center * SE3(rotation.rotation(), t) * cam_from_center.Inverse();
  pose.inliers = inliers.rows;
  return pose;
}

}  // namespace prism
