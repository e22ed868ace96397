// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// What a light-field method relies on when it compares micro images with each other: a blank wall
// is flat after division by the white image, and one surface looks the same behind neighbouring
// lenses.
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "prism/camera/projection.h"
#include "prism/sim/counter_random.h"
#include "prism/sim/procedural_texture.h"
#include "prism/sim/renderer.h"
#include "prism/sim/sensor.h"
#include "test/sim/test_scene.h"

namespace prism {
namespace {

struct Moments {
  double n = 0, sum = 0, sum2 = 0;
  void Add(double value) {
    n += 1;
    sum += value;
    sum2 += value * value;
  }
  double mean() const { return sum / n; }
  double sigma() const { return std::sqrt(std::max(0.0, sum2 / n - mean() * mean())); }
};

TEST(MicroImageTest, TransmissionIsTheShareOfRaysTheMainLensLetsThrough) {
  const PlenopticCamera camera = SmallCamera();
  const PlenopticOptics optics(camera, OpticsOptions());
  CounterRandom random(1, 0, 0);
  std::array<int, 3> partly_open = {};
  for (int k = 0; k < 150; ++k) {
    const Eigen::Vector2d raw_px(240 + 15 * random.Uniform(), 240 + 15 * random.Uniform());
    const PlenopticOptics::MicroLens lens = optics.LensOf(raw_px);
    const double expected = optics.Transmission(raw_px, lens);
    constexpr int kRays = 20000;
    int open = 0;
    for (int i = 0; i < kRays; ++i) {
      const Eigen::Vector2d in_pixel(random.Uniform() - 0.5, random.Uniform() - 0.5);
      const double r = std::sqrt(random.Uniform());
      const double phi = 2 * M_PI * random.Uniform();
      PlenopticOptics::Ray ray;
      open += optics.Trace(raw_px + in_pixel, lens, {r * std::cos(phi), r * std::sin(phi)}, &ray);
    }
    const double cos2 = 1 / (1 + (lens.center / camera.main_lens_mla_distance).squaredNorm());
    EXPECT_NEAR(expected, cos2 * cos2 * open / kRays, 4 * 0.5 / std::sqrt(kRays) + 2e-3)
        << raw_px.transpose();
    if (expected > 0.1 && expected < 0.9) ++partly_open[lens.type];
  }
  for (const int count : partly_open) EXPECT_GE(count, 5);
}

// Raw over white before a blank wall, by lens type and distance from the micro image's centre.
void ExpectFlat(double z) {
  constexpr int kRings = 12;  // of a twentieth of the pitch
  const PlenopticCamera camera = SmallCamera();
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  SimScene scene = WhiteScene();
  AddPatch({0, 0, z}, {3 * z, 0, 0}, {0, 3 * z, 0}, &scene);
  const RayCaster caster(scene);
  const PlenopticOptics optics(camera, OpticsOptions());
  const cv::Mat white = RenderWhite(optics);
  SensorOptions sensor;
  sensor.bits = 16;
  const cv::Mat raw =
      ReadSensor(RenderRaw(caster, optics, white, {SE3()}, RenderOptions(), 0), 0.9, sensor, 0);
  std::array<std::array<Moments, kRings>, 3> residuals;  // in standard deviations of the sensor
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      const double expected = 0.9 * white.at<float>(y, x);
      if (expected < 0.02) continue;
      const Eigen::Vector2d raw_px(x, y);
      const LensIndex lens = grid.NearestLens(raw_px, raw.cols, raw.rows);
      const double r = (raw_px - grid.MicroImageCenter(lens, raw.cols, raw.rows)).norm();
      const int ring = static_cast<int>(20 * r / grid.diameter_px);
      if (ring >= kRings) continue;
      const double electrons = expected * sensor.full_well_electrons;
      const double sigma =
          std::sqrt(electrons + std::pow(sensor.read_noise_electrons, 2)) / electrons;
      residuals[grid.TypeOf(lens)][ring].Add((raw.at<uint16_t>(y, x) / 65535.0 / expected - 1) /
                                             sigma);
    }
  }
  for (size_t type = 0; type < 3; ++type) {
    for (int ring = 0; ring < kRings; ++ring) {
      const Moments& m = residuals[type][ring];
      if (m.n < 300) continue;
      EXPECT_NEAR(m.mean(), 0, 4.5 / std::sqrt(m.n)) << "type " << type << ", ring " << ring;
      EXPECT_NEAR(m.sigma(), 1, 3.5 / std::sqrt(m.n)) << "type " << type << ", ring " << ring;
    }
  }
}

TEST(MicroImageTest, ABlankWallOverTheWhiteImageIsFlatToTheSensorsNoise) {
  for (const double z : {0.5, 1.5, 8.0}) ExpectFlat(z);
}

double InterpolateCubic(const cv::Mat& image, double x, double y) {
  const auto weights = [](double t) {
    return std::array<double, 4>{t * (-0.5 + t * (1 - 0.5 * t)),
                                 1 + t * t * (-2.5 + 1.5 * t),
                                 t * (0.5 + t * (2 - 1.5 * t)),
                                 t * t * (-0.5 + 0.5 * t)};
  };
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const auto wx = weights(x - x0);
  const auto wy = weights(y - y0);
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) sum += wy[j] * wx[i] * image.at<float>(y0 - 1 + j, x0 - 1 + i);
  }
  return sum;
}

// A slanted wall of a procedural texture, and its raw image divided by the white one.
struct SlantedWall {
  SlantedWall(const PlenopticCamera& camera, const std::string& kind, int samples)
      : right(3, 0, 1.4), scene(WhiteScene()) {
    scene.textures[0] = Texture(MakeTexture(kind, 1024, 4));
    SurfaceStyle style;
    style.texture_size = {0.9, 0.9};
    AddQuad(middle - 0.5 * (right + down), right, down, style, &scene.meshes[0]);
    const RayCaster caster(scene);
    const PlenopticOptics optics(camera, OpticsOptions());
    white = RenderWhite(optics);
    RenderOptions options;
    options.samples = samples;
    cv::extractChannel(RenderRaw(caster, optics, white, {SE3()}, options, 0), flat, 1);
    flat /= cv::max(white, 1e-3);
  }

  Eigen::Vector3d middle{0, 0, 1.6};
  Eigen::Vector3d right;
  Eigen::Vector3d down{0, 3, 0};
  SimScene scene;
  cv::Mat white;
  cv::Mat flat;
};

// RMS difference of what two neighbouring lenses of one type see of the same points, over the mean.
double Disagreement(const PlenopticCamera& camera, const SlantedWall& wall) {
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  const PlenopticOptics optics(camera, OpticsOptions());
  const Eigen::Vector3d n = wall.right.cross(wall.down);
  const int size = camera.raw_width;
  Moments differences;
  Moments values;
  for (int y = 30; y < size - 30; ++y) {
    for (int x = 30; x < size - 30; ++x) {
      if (wall.white.at<float>(y, x) < 0.9f) continue;
      const Eigen::Vector2d raw_px(x, y);
      const LensIndex lens = grid.NearestLens(raw_px, size, size);
      PlenopticOptics::Ray ray;
      if (!optics.Trace(raw_px, optics.LensOf(raw_px), {0, 0}, &ray)) continue;
      const Eigen::Vector3d origin(ray.origin_xy.x(), ray.origin_xy.y(), 0);
      const Eigen::Vector3d direction(ray.direction_xy.x(), ray.direction_xy.y(), 1);
      const Eigen::Vector3d x_C =
          origin + n.dot(wall.middle - origin) / n.dot(direction) * direction;
      Eigen::Vector3d x_V;
      CHECK(Project(PlenopticProjection(camera), x_C, &x_V));
      x_V.head<2>() = RawFromFocused(camera, x_V.head<2>());
      for (const auto& [i, j] : {std::pair(1, 1), std::pair(2, -1), std::pair(-1, 2)}) {
        const LensIndex other{lens.i + i, lens.j + j};
        CHECK_EQ(grid.TypeOf(other), grid.TypeOf(lens));
        const Eigen::Vector2d c_I = grid.MicroImageCenter(other, size, size);
        const Eigen::Vector2d p = ProjectToRaw(camera, x_V, MicroLensCenter(camera, c_I));
        if ((p - c_I).norm() > 0.32 * grid.diameter_px) continue;
        const double value = wall.flat.at<float>(y, x);
        differences.Add(value - InterpolateCubic(wall.flat, p.x(), p.y()));
        values.Add(value);
      }
    }
  }
  CHECK_GT(values.n, 500);
  CHECK_GT(values.sigma(), 0.1 * values.mean());  // there is texture
  return std::sqrt(differences.sum2 / differences.n) / values.mean();
}

TEST(MicroImageTest, NeighbouringLensesSeeTheSameTextureOnASlantedWall) {
  const PlenopticCamera camera = SmallCamera();
  for (const std::string kind : {"bricks", "poster", "painting"}) {
    const double few = Disagreement(camera, SlantedWall(camera, kind, 4));
    const double many = Disagreement(camera, SlantedWall(camera, kind, 64));
    // The differences of two pixels of a sensor with 8000 electrons at full scale have 2 to 3 %.
    EXPECT_LT(few, 0.045) << kind;
    EXPECT_LT(many, 0.022) << kind;
  }
}

}  // namespace
}  // namespace prism
