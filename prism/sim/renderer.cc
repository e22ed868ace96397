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

// Points tried on a micro lens of which the main lens leaves but a small part open.
constexpr int kMaxTries = 256;

// Position in the pixel (2), on the micro lens (2), in the exposure (1), each in [0, 1).
using Sample = std::array<double, 5>;

uint32_t ReverseBits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0f) << 4) | ((x >> 4) & 0x0f0f0f0f);
  x = ((x & 0x33333333) << 2) | ((x >> 2) & 0x33333333);
  return ((x & 0x55555555) << 1) | ((x >> 1) & 0x55555555);
}

// Flips every bit at random, depending on the bits below it alone: the mirror image of Owen's
// scrambling, by the hash of S. Laine and T. Karras with the constants of N. Vegdahl.
uint32_t FlipFromBelow(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adea;
  x += seed;
  x *= (seed >> 16) | 1;
  x ^= x * 0x05526c56;
  x ^= x * 0x53a22864;
  return x;
}

// A (0, 2)-sequence (van der Corput and the second dimension of Sobol'), scrambled by Owen's method
// and in random order: of any four of its points that begin at a multiple of four, one lies in each
// quarter of the square and in each quarter of either axis; so for all powers of two.
class SquareSequence {
 public:
  explicit SquareSequence(CounterRandom* random) {
    for (uint32_t& seed : seeds_) seed = static_cast<uint32_t>(random->Next() >> 32);
  }
  void Point(uint32_t index, double* x, double* y) const {
    const uint32_t n = ReverseBits(FlipFromBelow(ReverseBits(index), seeds_[0]));
    uint32_t pascal = n;  // the matrix of binomial coefficients mod 2, times n
    pascal ^= pascal >> 16;
    pascal ^= (pascal & 0xff00ff00) >> 8;
    pascal ^= (pascal & 0xf0f0f0f0) >> 4;
    pascal ^= (pascal & 0xcccccccc) >> 2;
    pascal ^= (pascal & 0xaaaaaaaa) >> 1;
    *x = ReverseBits(FlipFromBelow(n, seeds_[1])) * 0x1p-32;
    *y = ReverseBits(FlipFromBelow(pascal, seeds_[2])) * 0x1p-32;
  }

 private:
  uint32_t seeds_[3] = {};
};

// The samples of one pixel: few of them are enough, being evenly spread over pixel and lens.
class SampleSequence {
 public:
  explicit SampleSequence(CounterRandom* random)
      : pixel_(random), lens_(random), moment_(random->Uniform()) {}
  Sample Next() {
    constexpr double kGoldenRatio = 0.6180339887498949;
    Sample sample;
    pixel_.Point(index_, &sample[0], &sample[1]);
    lens_.Point(index_, &sample[2], &sample[3]);
    sample[4] = moment_;
    ++index_;
    moment_ += kGoldenRatio;
    if (moment_ >= 1) moment_ -= 1;
    return sample;
  }

 private:
  SquareSequence pixel_;
  SquareSequence lens_;
  double moment_;
  uint32_t index_ = 0;
};

// The unit square on the unit disc, concentric squares on circles (Shirley and Chiu, 1997), which
// keeps evenly spread points evenly spread.
Eigen::Vector2d UnitDisc(double u, double v) {
  const double x = 2 * u - 1;
  const double y = 2 * v - 1;
  if (x == 0 && y == 0) return {0, 0};
  const bool wide = std::abs(x) > std::abs(y);
  const double r = wide ? x : y;
  const double phi = wide ? M_PI / 4 * (y / x) : M_PI / 2 - M_PI / 4 * (x / y);
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

// A pixel's n samples see a surface each through a filter, the texture's pyramid. What they see
// together has the variance of the pixel and of the micro lens' spot if the filters have a share of
// it and the samples spread over the rest. With a share of 2 / n the filters overlap, and few
// samples make little noise.
double FilterShare(int samples) { return std::min(1.0, 2.0 / samples); }

// Side of the square on a surface at depth z that a sample stands for, m. A trilinear
// pyramid looked up with a footprint has the variance of a box and of linear interpolation, 1/12
// and 1/6 of the footprint squared; between two levels up to a quarter more, 16 % in the mean.
float SampleFootprint(const PlenopticOptics& optics, int type, double z, int samples) {
  constexpr double kPyramidVariance = 1.16 * (1.0 / 12 + 1.0 / 6);
  const double spot = optics.SpotDiameterAtDepth(type, z);
  const double variance = 1.0 / 12 + spot * spot / 16;  // raw px^2, in x and in y
  return static_cast<float>(std::sqrt(variance * FilterShare(samples) / kPyramidVariance) *
                            optics.Footprint(z));
}

// Mean radiance of the light that reaches a pixel.
Rgb MeanRadiance(const RayCaster& caster,
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
      sum += caster.Radiance(hits[i], footprint);
    }
    num_cast += in_packet;
    in_packet = 0;
  };
  const double spread = std::sqrt(1 - FilterShare(options.samples));
  const int max_tries = std::max(options.samples, kMaxTries);
  for (int i = 0; i < max_tries && num_cast + in_packet < options.samples; ++i) {
    const Sample sample = sequence.Next();
    // At the rim of a micro image only what lies beyond the spread may be open.
    const double reach = i < options.samples ? spread : 1;
    PlenopticOptics::Ray ray;
    if (!optics.Trace({x + reach * (sample[0] - 0.5), y + reach * (sample[1] - 0.5)},
                      lens,
                      reach * UnitDisc(sample[2], sample[3]),
                      &ray)) {
      continue;
    }
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
  return num_cast > 0 ? Rgb(sum / static_cast<float>(num_cast)) : Rgb(Rgb::Zero());
}

}  // namespace

bool RenderOptions::IsValid(std::string* error) const {
  if (samples >= 1 && samples <= 65536) return true;
  *error = std::to_string(samples) + " samples a pixel, expected 1 to 65536";
  return false;
}

cv::Mat RenderWhite(const PlenopticOptics& optics) {
  cv::Mat image(optics.camera().raw_height, optics.camera().raw_width, CV_32FC1);
  tbb::parallel_for(0, image.rows, [&](int y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector2d raw_px(x, y);
      image.at<float>(y, x) =
          static_cast<float>(optics.Transmission(raw_px, optics.LensOf(raw_px)));
    }
  });
  return image;
}

cv::Mat RenderRaw(const RayCaster& caster,
                  const PlenopticOptics& optics,
                  const cv::Mat& white,
                  const std::vector<SE3>& world_from_cam,
                  const RenderOptions& options,
                  uint64_t frame) {
  CHECK(!world_from_cam.empty());
  CHECK_EQ(white.rows, optics.camera().raw_height);
  CHECK_EQ(white.cols, optics.camera().raw_width);
  const std::vector<Placed> poses = Place(world_from_cam);
  cv::Mat image(white.size(), CV_32FC3, cv::Scalar::all(0));
  tbb::parallel_for(0, image.rows, [&](int y) {
    auto* row = image.ptr<cv::Vec3f>(y);
    for (int x = 0; x < image.cols; ++x) {
      const float transmission = white.at<float>(y, x);
      if (transmission == 0) continue;
      const CounterRandom random(options.seed, frame, PixelIndex(x, y));
      row[x] = Bgr(transmission * MeanRadiance(caster, optics, poses, options, x, y, random));
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
        sum += caster.Radiance(hit, hit.t / static_cast<float>(focal_length));
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
  const double B = camera.virtual_depth_sign() * camera.sensor_mla_distance;
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
          static_cast<float>(B / (b_L - camera.main_lens_mla_distance));
    }
  });
  return truth;
}

}  // namespace prism
