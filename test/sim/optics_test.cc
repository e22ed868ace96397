// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// The renderer against the projection equations: a small light in a dark scene, and where the raw
// image lights up.
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "prism/camera/projection.h"
#include "prism/sim/renderer.h"
#include "test/sim/test_scene.h"

namespace prism {
namespace {

// The light's image behind one micro lens.
struct Spot {
  LensIndex lens;
  int type = 0;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // raw px, weighted by radiance
  double variance = 0;                               // along one axis, px^2
};

// Spots of a raw image in all cells that hold light, cells at the image border left out.
std::vector<Spot> FindSpots(const cv::Mat& raw, const PlenopticCamera& camera) {
  struct Sums {
    double weight = 0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    double second = 0;
  };
  std::map<std::pair<int, int>, Sums> cells;
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      const double value = raw.at<cv::Vec3f>(y, x)[1];
      if (value == 0) continue;
      const Eigen::Vector2d p(x, y);
      const LensIndex lens =
          camera.micro_lens_grid->NearestLens(p, camera.raw_width, camera.raw_height);
      Sums& sums = cells[{lens.i, lens.j}];
      sums.weight += value;
      sums.first += value * p;
      sums.second += value * p.squaredNorm();
    }
  }
  std::vector<Spot> spots;
  for (const auto& [index, sums] : cells) {
    Spot spot;
    spot.lens = {index.first, index.second};
    spot.type = camera.micro_lens_grid->TypeOf(spot.lens);
    spot.center = sums.first / sums.weight;
    spot.variance = 0.5 * (sums.second / sums.weight - spot.center.squaredNorm());
    spots.push_back(spot);
  }
  return spots;
}

// Where Eqs. (6)-(8) and (10) put a point behind a micro lens, raw px as on the sensor.
Eigen::Vector2d ExpectedPixel(const PlenopticCamera& camera,
                              const Eigen::Vector3d& x_C,
                              const LensIndex& lens) {
  Eigen::Vector3d x_V;
  CHECK(Project(PlenopticProjection(camera), x_C, &x_V));
  x_V.head<2>() = RawFromFocused(camera, x_V.head<2>());
  const Eigen::Vector2d c_I =
      camera.micro_lens_grid->MicroImageCenter(lens, camera.raw_width, camera.raw_height);
  const Eigen::Vector2d c_ML = MicroLensCenter(camera, UndistortRaw(camera, c_I));
  return DistortRaw(camera, ProjectToRaw(camera, x_V, c_ML));
}

// A part of the small camera's sensor, so that many samples a pixel can be afforded. The principal
// point is near its corner: angles are as large as in the whole.
PlenopticCamera CroppedCamera() {
  PlenopticCamera camera = SmallCamera();
  camera.raw_width = camera.raw_height = 240;
  camera.raw_principal_point = {13.2, 26.9};
  return camera;
}

// The same with real images before the micro lenses, at most v_infinity B.
PlenopticCamera CroppedKeplerianCamera(double v_infinity) {
  PlenopticCamera camera = CroppedCamera();
  camera.mode = MicroLensMode::kKeplerian;
  camera.main_lens_mla_distance = camera.focal_length + v_infinity * camera.sensor_mla_distance;
  return camera;
}

// Lights at one depth, `side` x `side` over the image: so far apart that no micro image holds two.
std::vector<Eigen::Vector3d> LightsAt(const PlenopticCamera& camera, double z, int side = 2) {
  const PlenopticProjection projection(camera);
  std::vector<Eigen::Vector3d> lights;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const Eigen::Vector2d focused_px =
          Eigen::Vector2d(37.3, 41.9) + Eigen::Vector2d(55.7 * i, 53.1 * j) / (side - 1);
      lights.push_back(UnprojectInverseDepth(projection, focused_px, 1 / z));
    }
  }
  return lights;
}

// Square lights facing the camera, black all around.
cv::Mat RenderLights(const PlenopticCamera& camera,
                     const std::vector<Eigen::Vector3d>& lights,
                     double side,
                     double micro_lens_aperture,
                     int samples) {
  SimScene scene = WhiteScene();
  for (const Eigen::Vector3d& light : lights) {
    AddPatch(light, {side, 0, 0}, {0, side, 0}, &scene);
  }
  const RayCaster caster(scene);
  OpticsOptions options;
  options.micro_lens_aperture = micro_lens_aperture;
  RenderOptions render;
  render.samples = samples;
  const PlenopticOptics optics(camera, options);
  return RenderRaw(caster, optics, RenderWhite(optics), {SE3()}, render, 0);
}

// The spots in the inner part of their micro images, each with the pixel expected for its light.
struct Match {
  Spot spot;
  Eigen::Vector2d expected;
};

std::vector<Match> MatchSpots(const PlenopticCamera& camera,
                              const std::vector<Eigen::Vector3d>& lights,
                              const cv::Mat& raw,
                              double inner_diameters) {
  std::vector<Match> matches;
  for (const Spot& spot : FindSpots(raw, camera)) {
    const Eigen::Vector2d c_I =
        camera.micro_lens_grid->MicroImageCenter(spot.lens, camera.raw_width, camera.raw_height);
    for (const Eigen::Vector3d& light : lights) {
      const Eigen::Vector2d expected = ExpectedPixel(camera, light, spot.lens);
      if ((expected - c_I).norm() > inner_diameters * camera.micro_lens_grid->diameter_px) continue;
      matches.push_back({spot, expected});
    }
  }
  return matches;
}

void ExpectSpotsWhereTheEquationsSay(const PlenopticCamera& camera,
                                     double z,
                                     double micro_lens_aperture) {
  const double side = 2 * PlenopticOptics(camera, OpticsOptions()).Footprint(z);
  const std::vector<Eigen::Vector3d> lights = LightsAt(camera, z);
  const cv::Mat raw = RenderLights(camera, lights, side, micro_lens_aperture, 256);
  const std::vector<Match> matches = MatchSpots(camera, lights, raw, 0.28);
  EXPECT_GE(matches.size(), lights.size());
  for (const auto& [spot, expected] : matches) {
    EXPECT_LT((spot.center - expected).norm(), 0.05)
        << "depth " << z << " m, lens (" << spot.lens.i << ", " << spot.lens.j << "), lit at "
        << spot.center.transpose() << ", expected " << expected.transpose();
  }
}

TEST(OpticsTest, APointLightsTheRawPixelsOfTheProjectionEquations) {
  for (const double z : {0.4, 6.0}) ExpectSpotsWhereTheEquationsSay(CroppedCamera(), z, 0);
}

TEST(OpticsTest, SoItDoesBeforeKeplerianMicroLenses) {
  for (const double z : {0.4, 6.0}) {
    ExpectSpotsWhereTheEquationsSay(CroppedKeplerianCamera(3.5), z, 0);
  }
}

TEST(OpticsTest, SoItDoesWithLensDistortion) {
  PlenopticCamera camera = CroppedCamera();
  camera.distortion = {8e3, 1e8, 0.4, -0.3};  // several px at the border
  ASSERT_GT((DistortRaw(camera, {230, 220}) - Eigen::Vector2d(230, 220)).norm(), 3);
  ExpectSpotsWhereTheEquationsSay(camera, 1.5, 0);
}

class OpticsOf : public ::testing::TestWithParam<PlenopticCamera> {};

INSTANTIATE_TEST_SUITE_P(Modes,
                         OpticsOf,
                         ::testing::Values(CroppedCamera(), CroppedKeplerianCamera(9)),
                         [](const auto& test) { return std::string(ToString(test.param.mode)); });

TEST_P(OpticsOf, SpotsGrowOffFocusAsTheThinLensFormulaSays) {
  constexpr double kAperture = 0.7;
  constexpr double kSidePx = 1;
  const PlenopticCamera& camera = GetParam();
  OpticsOptions options;
  options.micro_lens_aperture = kAperture;
  const PlenopticOptics optics(camera, options);
  std::map<int, int> compared;
  std::map<int, int> in_focus;
  for (const double v : {optics.FocusVirtualDepth(0),
                         optics.FocusVirtualDepth(1),
                         4.5,
                         optics.FocusVirtualDepth(2)}) {
    const double b_L = camera.main_lens_mla_distance +
                       camera.virtual_depth_sign() * v * camera.sensor_mla_distance;
    const double z = 1 / (1 / camera.focal_length - 1 / b_L);
    const std::vector<Eigen::Vector3d> lights = LightsAt(camera, z, v < 3 ? 3 : 2);
    const cv::Mat raw = RenderLights(camera, lights, kSidePx * optics.Footprint(z), kAperture, 256);
    for (const auto& [spot, expected] : MatchSpots(camera, lights, raw, 0.2)) {
      // |1/v - 1/v_k| times the lens diameter, worked out here and not by the optics.
      const double b_L0 = camera.main_lens_mla_distance;
      const double lens_px = kAperture * camera.micro_lens_grid->diameter_px * b_L0 /
                             (b_L0 + camera.sensor_mla_distance);
      const double diameter_px =
          lens_px * std::abs(1 / v - 1 / optics.FocusVirtualDepth(spot.type));
      // A uniform disc has variance d^2 / 16, the square light and the pixel 1 / 12 each.
      const double sigma =
          std::sqrt(diameter_px * diameter_px / 16 + (kSidePx * kSidePx + 1) / 12.0);
      if (diameter_px > 0.3) {
        EXPECT_NEAR(std::sqrt(spot.variance), sigma, 0.1 * sigma + 0.03)
            << "v " << v << ", type " << spot.type << ", diameter " << diameter_px;
      } else {  // in focus: about a pixel, how much depends on where in the pixel it is
        EXPECT_LT(4 * std::sqrt(spot.variance), 2.05) << "v " << v << ", type " << spot.type;
        ++in_focus[spot.type];
      }
      ++compared[spot.type];
    }
  }
  for (const int type : {0, 1, 2}) EXPECT_GE(in_focus[type], 1) << type;
  ASSERT_EQ(compared.size(), 3u);
  for (const auto& [type, count] : compared) EXPECT_GE(count, 2) << type;
}

TEST(OpticsTest, TheWhiteImageShowsTheGridAndIsDarkBetween) {
  const PlenopticCamera camera = SmallCamera();
  const MicroLensGrid& grid = *camera.micro_lens_grid;
  const cv::Mat white = RenderWhite(PlenopticOptics(camera, OpticsOptions()));
  // Middle of the bright part of each cell.
  std::map<std::pair<int, int>, std::vector<Eigen::Vector2d>> bright;
  for (int y = 20; y < white.rows - 20; ++y) {
    for (int x = 20; x < white.cols - 20; ++x) {
      const LensIndex lens = grid.NearestLens(Eigen::Vector2d(x, y), white.cols, white.rows);
      if (white.at<float>(y, x) > 0.5f) bright[{lens.i, lens.j}].emplace_back(x, y);
    }
  }
  Eigen::Vector2d mean_offset = Eigen::Vector2d::Zero();
  int compared = 0;
  for (const auto& [index, pixels] : bright) {
    const Eigen::Vector2d c_I =
        grid.MicroImageCenter({index.first, index.second}, white.cols, white.rows);
    if (c_I.minCoeff() < 40 || c_I.maxCoeff() > white.cols - 40) continue;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& pixel : pixels) sum += pixel;
    const Eigen::Vector2d offset = sum / static_cast<double>(pixels.size()) - c_I;
    EXPECT_LT(offset.norm(), 0.25) << c_I.transpose();
    mean_offset += offset;
    ++compared;
  }
  EXPECT_GT(compared, 600);
  EXPECT_LT((mean_offset / compared).norm(), 0.05);
  // The corner between three cells is 1 / sqrt(3) pitches from each of them: beyond the aperture.
  const Eigen::Vector2d corner = (grid.MicroImageCenter({0, 0}, white.cols, white.rows) +
                                  grid.MicroImageCenter({1, 0}, white.cols, white.rows) +
                                  grid.MicroImageCenter({0, 1}, white.cols, white.rows)) /
                                 3;
  EXPECT_LT(white.at<float>(static_cast<int>(std::lround(corner.y())),
                            static_cast<int>(std::lround(corner.x()))),
            0.35);
}

TEST(OpticsTest, OptionsOutOfRangeAreNamed) {
  std::string error;
  OpticsOptions options;
  options.micro_lens_aperture = 1.5;
  EXPECT_FALSE(options.IsValid(&error));
  EXPECT_NE(error.find("1.5"), std::string::npos);
}

}  // namespace
}  // namespace prism
