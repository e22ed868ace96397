// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/tracks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace prism {
namespace {

constexpr int kWindow_px = 13;
constexpr double kMinEigenvalue = 2e-3;  // corners and texture, no plain edges
constexpr double kMaxDifference = 20;    // of normalised intensities, mean over the window

// Intensities relative to those around, in units of their scatter: exposures cancel.
cv::Mat Normalize(const cv::Mat& gray) {
  constexpr double kNoise = 4;  // plain areas are not blown up
  cv::Mat image, mean, square, scatter;
  gray.convertTo(image, CV_32F);
  const cv::Size window(31, 31);
  cv::boxFilter(image, mean, CV_32F, window);
  cv::sqrBoxFilter(image, square, CV_32F, window);
  cv::sqrt(cv::max(square - mean.mul(mean), 0), scatter);
  cv::Mat normalized = (image - mean) / (scatter + kNoise) * 40 + 128;
  normalized.convertTo(normalized, CV_8U);
  return normalized;
}

// What Lucas-Kanade wants of an image, of the keyframes around the one at hand.
class ImageCache {
 public:
  explicit ImageCache(const ExportRun& run) : run_(run) {}

  const std::vector<cv::Mat>& Get(int keyframe) {
    std::vector<cv::Mat>& pyramid = pyramids_[keyframe];
    if (pyramid.empty()) {
      cv::buildOpticalFlowPyramid(Normalize(DecodeGray(run_.keyframes[keyframe])),
                                  pyramid,
                                  cv::Size(kWindow_px, kWindow_px),
                                  0);
    }
    return pyramid;
  }
  void ForgetBefore(int keyframe) {
    pyramids_.erase(pyramids_.begin(), pyramids_.lower_bound(keyframe));
  }

 private:
  const ExportRun& run_;
  std::map<int, std::vector<cv::Mat>> pyramids_;
};

struct Matches {
  std::vector<cv::Point2f> px;
  std::vector<uchar> is_found;
};

Matches Match(const std::vector<cv::Mat>& from,
              const std::vector<cv::Mat>& to,
              const std::vector<cv::Point2f>& px_from,
              const std::vector<cv::Point2f>& start) {
  Matches matches;
  matches.px = start;
  std::vector<float> difference;
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.003);
  cv::calcOpticalFlowPyrLK(from,
                           to,
                           px_from,
                           matches.px,
                           matches.is_found,
                           difference,
                           cv::Size(kWindow_px, kWindow_px),
                           0,
                           criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW,
                           kMinEigenvalue);
  for (size_t i = 0; i < difference.size(); ++i) {
    if (difference[i] > kMaxDifference) matches.is_found[i] = 0;
  }
  return matches;
}

double Distance(const cv::Point2f& a, const cv::Point2f& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

double RollDeg(const SE3& target_from_host) {
  const Eigen::Matrix3d R = target_from_host.RotationMatrix();
  return std::abs(std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1))) * 180 / M_PI;
}

}  // namespace

bool ProjectToKeyframe(const PlenopticProjection& camera,
                       const SE3& cam_from_world,
                       const Eigen::Vector3d& p_in_world,
                       Eigen::Vector2d* px) {
  const Eigen::Vector3d p = cam_from_world * p_in_world;
  const double zeta = p.z() - camera.center_z();
  if (zeta <= 0) return false;
  *px = camera.c + camera.FocalLengthPx() / zeta * p.head<2>();
  return true;
}

std::vector<Track> FindTracks(const ExportRun& run, const TrackOptions& options) {
  const int count = static_cast<int>(run.keyframes.size());
  std::map<int, int> index_of_id;
  for (int i = 0; i < count; ++i) index_of_id[run.keyframes[i].id] = i;
  std::vector<std::vector<int>> points_of_host(count);
  std::vector<Track> tracks(run.points.size());
  for (size_t i = 0; i < run.points.size(); ++i) {
    const int host = index_of_id.at(run.points[i].keyframe_id);
    points_of_host[host].push_back(static_cast<int>(i));
  }

  ImageCache images(run);
  for (int host = 0; host < count; ++host) {
    images.ForgetBefore(host - options.max_distance);
    const SE3 host_from_world = run.keyframes[host].world_from_cam.Inverse();
    const int last = std::min(count - 1, host + options.max_distance);
    for (int target = std::max(0, host - options.max_distance); target <= last; ++target) {
      if (target == host) {
        for (const int point : points_of_host[host]) {
          tracks[point].observations.push_back({host, run.points[point].px});
        }
        continue;
      }
      const SE3 target_from_world = run.keyframes[target].world_from_cam.Inverse();
      if (RollDeg(target_from_world * host_from_world.Inverse()) > options.max_roll_deg) continue;
      std::vector<int> looked_for;
      std::vector<cv::Point2f> px_in_host, projections;
      for (const int point : points_of_host[host]) {
        const Eigen::Vector3d& p = run.points[point].p_in_world;
        Eigen::Vector2d px;
        if (!ProjectToKeyframe(run.camera, target_from_world, p, &px)) continue;
        const double margin = 0.5 * kWindow_px;
        if (px.x() < margin || px.y() < margin || px.x() > run.camera.width - 1 - margin ||
            px.y() > run.camera.height - 1 - margin) {
          continue;
        }
        const double scale = (host_from_world * p).z() / (target_from_world * p).z();
        if (std::max(scale, 1 / scale) > options.max_scale) continue;
        looked_for.push_back(point);
        px_in_host.emplace_back(static_cast<float>(run.points[point].px.x()),
                                static_cast<float>(run.points[point].px.y()));
        projections.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
      }
      if (looked_for.empty()) continue;
      const Matches there = Match(images.Get(host), images.Get(target), px_in_host, projections);
      const Matches back = Match(images.Get(target), images.Get(host), there.px, px_in_host);
      for (size_t i = 0; i < looked_for.size(); ++i) {
        const double error = Distance(there.px[i], projections[i]);
        if (there.is_found[i] == 0 || back.is_found[i] == 0 || error > options.max_reprojection ||
            Distance(back.px[i], px_in_host[i]) > options.max_return) {
          continue;
        }
        Track& track = tracks[looked_for[i]];
        track.observations.push_back({target, {there.px[i].x, there.px[i].y}});
        track.mean_error += error;
      }
    }
    for (const int point : points_of_host[host]) {
      const size_t others = tracks[point].observations.size() - 1;
      if (others > 0) tracks[point].mean_error /= static_cast<double>(others);
    }
  }
  return tracks;
}

}  // namespace prism
