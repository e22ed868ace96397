// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/renderer.h"

#include <array>
#include <cmath>

#include <glog/logging.h>
#include <tbb/parallel_for.h>

#include "prism/sim/counter_random.h"

namespace prism {
namespace {

// Powers of 1/x for the root of x^6 = x + 1: the additive recurrence that covers five dimensions
// evenly for any number of samples (M. Roberts' R sequence).
constexpr std::array<double, 5> kRecurrence = {0.8812714616335696,
                                               0.7766393890897682,
                                               0.6844301295853426,
                                               0.6031687406857282,
                                               0.5315553977157913};

constexpr int kTransmissionSamples = 32;

// Position in the pixel (2), on the micro lens (2), in the exposure (1), each in [0, 1).
using Sample = std::array<double, 5>;

// The samples of one pixel: the recurrence from a random start.
class SampleSequence {
 public:
  explicit SampleSequence(CounterRandom* random) {
    for (double& value : next_) value = random->Uniform();
  }
  Sample Next() {
    const Sample sample = next_;
    for (size_t i = 0; i < next_.size(); ++i) {
      next_[i] += kRecurrence[i];
      if (next_[i] >= 1) next_[i] -= 1;
    }
    return sample;
  }

 private:
  Sample next_;
};

Eigen::Vector2d UnitDisc(double u, double v) {
  const double r = std::sqrt(u);
  const double phi = 2 * M_PI * v;
  return {r * std::cos(phi), r * std::sin(phi)};
}

struct Placed {
  Eigen::Matrix3f R;
  Eigen::Vector3f t;
};

std::vector<Placed> Place(const std::vector<SE3>& world_from_cam) {
  std::vector<Placed> placed;
  for (const SE3& pose : world_from_cam) {
    placed.push_back({pose.RotationMatrix().cast<float>(), pose.translation().cast<float>()});
  }
  return placed;
}

uint64_t PixelIndex(int x, int y) {
  return (static_cast<uint64_t>(y) << 32) | static_cast<uint32_t>(x);
}

cv::Vec3f Bgr(const Rgb& rgb) { return {rgb[2], rgb[1], rgb[0]}; }

// Side of the square on a surface at depth z that one of a pixel's samples stands for, m: its share
// of the pixel widened by the micro lens' defocus. Filtering by it keeps blurred textures smooth
// with few samples.
float SampleFootprint(const PlenopticOptics& optics, int type, double z, int samples) {
  constexpr double kOverlap = 1.25;  // neighbouring samples overlap a little
  const double spot = optics.SpotDiameterAtDepth(type, z);
  return static_cast<float>(kOverlap * std::sqrt((1 + spot * spot) / samples) *
                            optics.Footprint(z));
}

cv::Vec3f RawPixel(const RayCaster& caster,
                   const PlenopticOptics& optics,
                   const std::vector<Placed>& poses,
                   const RenderOptions& options,
                   int x,
                   int y,
                   CounterRandom random) {
  constexpr int kPacket = 4;
  const float near = static_cast<float>(optics.camera().focal_length);
  const PlenopticOptics::MicroLens lens = optics.LensOf(Eigen::Vector2d(x, y));
  SampleSequence sequence(&random);
  // How much gets through is counted over more samples than are cast into the scene: at the rim of
  // a micro image four samples would make a noise far above the sensor's.
  const int num_tried = optics.IsOpen(Eigen::Vector2d(x, y), lens)
                            ? options.samples
                            : std::max(options.samples, kTransmissionSamples);
  int num_open = 0;
  int num_cast = 0;
  int in_packet = 0;
  SimRay rays[kPacket];
  Rgb sum = Rgb::Zero();
  const auto cast = [&] {
    SimHit hits[kPacket];
    const bool wanted[kPacket] = {in_packet > 0, in_packet > 1, in_packet > 2, in_packet > 3};
    caster.Cast4(rays, wanted, near, hits);
    for (int i = 0; i < in_packet; ++i) {
      const float footprint =
          hits[i].found() ? SampleFootprint(optics, lens.type, hits[i].t, options.samples) : 0;
      sum += caster.Radiance(hits[i], footprint, random.Uniform());
    }
    num_cast += in_packet;
    in_packet = 0;
  };
  double cos4 = 0;
  for (int i = 0; i < num_tried; ++i) {
    const Sample sample = sequence.Next();
    PlenopticOptics::Ray ray;
    if (!optics.Trace({x + sample[0] - 0.5, y + sample[1] - 0.5},
                      lens,
                      UnitDisc(sample[2], sample[3]),
                      &ray)) {
      continue;
    }
    ++num_open;
    cos4 = ray.cos4;  // the same for a micro lens
    if (num_cast + in_packet == options.samples) continue;
    const auto moment = static_cast<size_t>(sample[4] * static_cast<double>(poses.size()));
    const Placed& pose = poses[moment];
    const Eigen::Vector3f origin(
        static_cast<float>(ray.origin_xy.x()), static_cast<float>(ray.origin_xy.y()), 0);
    const Eigen::Vector3f direction(
        static_cast<float>(ray.direction_xy.x()), static_cast<float>(ray.direction_xy.y()), 1);
    rays[in_packet++] = {pose.R * origin + pose.t, pose.R * direction};
    if (in_packet == kPacket) cast();
  }
  if (in_packet > 0) cast();
  if (num_cast == 0) return {0, 0, 0};
  const double transmission = cos4 * num_open / num_tried;
  return Bgr(sum * static_cast<float>(transmission / num_cast));
}

}  // namespace

bool RenderOptions::IsValid(std::string* error) const {
  if (samples >= 1 && samples <= 65536) return true;
  *error = std::to_string(samples) + " samples a pixel, expected 1 to 65536";
  return false;
}

cv::Mat RenderRaw(const RayCaster& caster,
                  const PlenopticOptics& optics,
                  const std::vector<SE3>& world_from_cam,
                  const RenderOptions& options,
                  uint64_t frame) {
  CHECK(!world_from_cam.empty());
  const std::vector<Placed> poses = Place(world_from_cam);
  cv::Mat image(optics.camera().raw_height, optics.camera().raw_width, CV_32FC3);
  tbb::parallel_for(0, image.rows, [&](int y) {
    auto* row = image.ptr<cv::Vec3f>(y);
    for (int x = 0; x < image.cols; ++x) {
      const CounterRandom random(options.seed, frame, PixelIndex(x, y));
      row[x] = RawPixel(caster, optics, poses, options, x, y, random);
    }
  });
  return image;
}

cv::Mat RenderWhite(const PlenopticOptics& optics, const RenderOptions& options) {
  cv::Mat image(optics.camera().raw_height, optics.camera().raw_width, CV_32FC1);
  tbb::parallel_for(0, image.rows, [&](int y) {
    for (int x = 0; x < image.cols; ++x) {
      const PlenopticOptics::MicroLens lens = optics.LensOf(Eigen::Vector2d(x, y));
      CounterRandom random(options.seed, ~uint64_t{0}, PixelIndex(x, y));
      SampleSequence sequence(&random);
      double sum = 0;
      for (int i = 0; i < options.samples; ++i) {
        const Sample sample = sequence.Next();
        PlenopticOptics::Ray ray;
        if (optics.Trace({x + sample[0] - 0.5, y + sample[1] - 0.5},
                         lens,
                         UnitDisc(sample[2], sample[3]),
                         &ray)) {
          sum += ray.cos4;
        }
      }
      image.at<float>(y, x) = static_cast<float>(sum / options.samples);
    }
  });
  return image;
}

cv::Mat RenderPreview(const RayCaster& caster,
                      const PlenopticCamera& camera,
                      const SE3& world_from_cam,
                      const RenderOptions& options,
                      int reduction) {
  const PinholeCamera pinhole = PinholeView(camera);
  const double focal_length = pinhole.fx / reduction;
  const double cx = (pinhole.cx + 0.5) / reduction - 0.5;
  const double cy = (pinhole.cy + 0.5) / reduction - 0.5;
  const std::vector<Placed> pose = Place({world_from_cam});
  cv::Mat image(pinhole.height / reduction, pinhole.width / reduction, CV_32FC3);
  tbb::parallel_for(0, image.rows, [&](int y) {
    for (int x = 0; x < image.cols; ++x) {
      CounterRandom random(options.seed, ~uint64_t{1}, PixelIndex(x, y));
      SampleSequence sequence(&random);
      Rgb sum = Rgb::Zero();
      for (int i = 0; i < options.samples; ++i) {
        const Sample sample = sequence.Next();
        const Eigen::Vector3d direction((x + sample[0] - 0.5 - cx) / focal_length,
                                        (y + sample[1] - 0.5 - cy) / focal_length,
                                        1);
        const SimHit hit = caster.Cast({pose[0].t, pose[0].R * direction.cast<float>()});
        sum += caster.Radiance(hit, hit.t / static_cast<float>(focal_length), random.Uniform());
      }
      image.at<cv::Vec3f>(y, x) = Bgr(sum / static_cast<float>(options.samples));
    }
  });
  return image;
}

DepthTruth RenderDepthTruth(const RayCaster& caster,
                            const PlenopticCamera& camera,
                            const SE3& world_from_cam) {
  const double f = camera.focal_length;
  const double s = camera.raw_pixel_size * camera.focused_scale;
  const Eigen::Vector2d c = (camera.raw_principal_point.array() + 0.5) / camera.focused_scale - 0.5;
  const Eigen::Matrix3d R = world_from_cam.RotationMatrix();
  const Eigen::Vector3d origin = world_from_cam * Eigen::Vector3d(0, 0, f);
  DepthTruth truth;
  truth.inverse_virtual_depth = ImageF(camera.focused_width(), camera.focused_height(), 0.0f);
  truth.depth = ImageF(camera.focused_width(), camera.focused_height(), 0.0f);
  tbb::parallel_for(0, truth.depth.height(), [&](int y) {
    for (int x = 0; x < truth.depth.width(); ++x) {
      const Eigen::Vector3d direction =
          R * Eigen::Vector3d((x - c.x()) * s / f, (y - c.y()) * s / f, 1);
      const SimHit hit = caster.Cast({origin.cast<float>(), direction.cast<float>()});
      if (!hit.found()) continue;
      const double z = f + caster.PreciseDepth(hit, origin, direction);
      const double b_L = 1 / (1 / f - 1 / z);
      truth.depth(x, y) = static_cast<float>(z);
      truth.inverse_virtual_depth(x, y) =
          static_cast<float>(camera.sensor_mla_distance / (b_L - camera.main_lens_mla_distance));
    }
  });
  return truth;
}

}  // namespace prism
