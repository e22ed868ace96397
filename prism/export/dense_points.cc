// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/dense_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "prism/base/format.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

// A keyframe's depth in metres, and what of it has been used.
struct MetricMap {
  RigidMotion cam_from_world, world_from_cam;
  ImageF rho;    // 1/m; 0 = none
  ImageF sigma;  // of rho
  cv::Mat image;
  std::vector<bool> is_used;
};

std::shared_ptr<MetricMap> Load(const PlenopticProjection& camera, const ExportKeyframe& keyframe) {
  auto map = std::make_shared<MetricMap>();
  map->cam_from_world = keyframe.world_from_cam.Inverse();
  map->world_from_cam = keyframe.world_from_cam;
  DepthMap depth = DecodeDepth(keyframe);
  const int width = depth.sigma.width(), height = depth.sigma.height();
  map->rho = ImageF(width, height, 0);
  map->sigma = ImageF(width, height, 0);
  map->is_used.assign(map->rho.size(), false);
  for (size_t i = 0; i < map->rho.size(); ++i) {
    const double w = depth.inverse_virtual_depth.data()[i];
    if (w == 0) continue;
    double drho_dw;
    const double rho = InverseDepth(camera, w, &drho_dw);
    if (rho <= 0 || rho * camera.f >= 1) continue;
    map->rho.data()[i] = static_cast<float>(rho);
    map->sigma.data()[i] = static_cast<float>(std::abs(drho_dw) * depth.sigma.data()[i]);
  }
  map->image = DecodeImage(keyframe);
  return map;
}

std::array<uint8_t, 3> ColourAt(const cv::Mat& image, int x, int y) {
  if (image.channels() == 1) {
    const uint8_t gray = image.at<uint8_t>(y, x);
    return {gray, gray, gray};
  }
  const auto& bgr = image.at<cv::Vec3b>(y, x);
  return {bgr[2], bgr[1], bgr[0]};
}

struct Sample {
  MetricMap* map;
  size_t pixel;
};

// What a neighbour says of a point in the world.
enum class Verdict { kNothing, kAgrees, kSeesThrough };

Verdict Ask(const PlenopticProjection& camera,
            MetricMap* other,
            const Eigen::Vector3d& p_in_world,
            double relative_sigma,
            double max_error,
            Sample* sample) {
  const Eigen::Vector3d p = other->cam_from_world.R * p_in_world + other->cam_from_world.t;
  const double zeta = p.z() - camera.center_z();
  if (zeta <= 0) return Verdict::kNothing;
  const Eigen::Vector2d px = camera.c + camera.FocalLengthPx() / zeta * p.head<2>();
  const int x = static_cast<int>(std::lround(px.x())), y = static_cast<int>(std::lround(px.y()));
  if (x < 0 || y < 0 || x >= other->rho.width() || y >= other->rho.height()) {
    return Verdict::kNothing;
  }
  const double rho = other->rho(x, y);
  if (rho == 0) return Verdict::kNothing;
  const double expected = 1 / p.z();
  const double error = (rho - expected) / std::hypot(other->sigma(x, y), expected * relative_sigma);
  if (error < -max_error) return Verdict::kSeesThrough;
  if (error > max_error) return Verdict::kNothing;  // something else may stand before it
  *sample = {other, static_cast<size_t>(y) * other->rho.width() + x};
  return Verdict::kAgrees;
}

}  // namespace

std::vector<OrientedPoint> FuseDepth(const ExportRun& run, const FusionOptions& options) {
  std::vector<OrientedPoint> points;
  std::map<int, std::shared_ptr<MetricMap>> maps;
  const int count = static_cast<int>(run.keyframes.size());
  for (int host = 0; host < count; ++host) {
    const int first = std::max(0, host - options.max_distance);
    const int last = std::min(count - 1, host + options.max_distance);
    maps.erase(maps.begin(), maps.lower_bound(first));
    for (int i = first; i <= last; ++i) {
      if (!maps[i]) maps[i] = Load(run.camera, run.keyframes[i]);
    }
    MetricMap& map = *maps[host];
    const Eigen::Vector3d center =
        WorldFromPinhole(run.camera, run.keyframes[host].world_from_cam).translation();
    for (int y = 0; y < map.rho.height(); ++y) {
      for (int x = 0; x < map.rho.width(); ++x) {
        const size_t pixel = static_cast<size_t>(y) * map.rho.width() + x;
        const double rho = map.rho(x, y);
        if (rho == 0 || map.is_used[pixel]) continue;
        const double sigma = map.sigma(x, y);
        const Eigen::Vector3d ray = UnprojectInverseDepth(run.camera, Eigen::Vector2d(x, y), rho);
        const Eigen::Vector3d p = map.world_from_cam.R * ray + map.world_from_cam.t;
        std::vector<Sample> agreeing;
        int against = 0;
        bool is_known = false;
        double weight = 1 / (sigma * sigma), sum = weight * rho;
        for (const auto& [index, other] : maps) {
          if (index == host) continue;
          Sample sample{};
          const Verdict verdict =
              Ask(run.camera, other.get(), p, sigma / rho, options.max_error, &sample);
          against += verdict == Verdict::kSeesThrough;
          if (verdict != Verdict::kAgrees) continue;
          // Pixels of two grids do not meet one to one: this surface is in the cloud already.
          is_known = is_known || (index < host && sample.map->is_used[sample.pixel]);
          agreeing.push_back(sample);
          // Its measurement, carried along the ray of this pixel.
          const double ratio =
              sample.map->rho.data()[sample.pixel] *
              (sample.map->cam_from_world.R * p + sample.map->cam_from_world.t).z();
          const double other_sigma =
              rho * sample.map->sigma.data()[sample.pixel] / sample.map->rho.data()[sample.pixel];
          weight += 1 / (other_sigma * other_sigma);
          sum += rho * ratio / (other_sigma * other_sigma);
        }
        const int agree = static_cast<int>(agreeing.size());
        if (is_known || agree < options.min_agreeing || against > agree) continue;
        map.is_used[pixel] = true;
        for (const Sample& sample : agreeing) sample.map->is_used[sample.pixel] = true;
        const double fused = sum / weight;
        const double relative_sigma = 1 / (std::sqrt(weight) * fused);
        if (relative_sigma > options.max_sigma) continue;
        const Eigen::Vector3d x_C = UnprojectInverseDepth(run.camera, Eigen::Vector2d(x, y), fused);
        const Eigen::Vector3d p_fused = map.world_from_cam.R * x_C + map.world_from_cam.t;
        points.push_back({p_fused.cast<float>(),
                          (center - p_fused).normalized().cast<float>(),
                          ColourAt(map.image, x, y),
                          static_cast<float>(relative_sigma * x_C.norm())});
      }
    }
  }
  return points;
}

std::string WriteDensePly(const std::string& folder, const ExportRun& run) {
  const std::vector<OrientedPoint> points = FuseDepth(run);
  WriteOrientedPly(InFolder(folder, "points_dense.ply"), points);
  return Format("%zu points", points.size());
}

}  // namespace prism
