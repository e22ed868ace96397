// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <utility>

#include "prism/base/random.h"
#include "prism/camera/projection.h"
#include "prism/image/patch.h"
#include "prism/scene/window.h"

namespace prism {

// A window onto a textured plane whose poses and depths are known exactly.
struct SyntheticOptions {
  int num_keyframes = 7;
  int num_points = 2000;
  int width = 640;
  int height = 480;
  double baseline = 0.02;  // m between keyframes
  double w_sigma = 0.004;  // noise of the measured 1/v
  double image_noise = 0;  // intensities
  // Whether frames have exact depths everywhere, as RenderPlane makes them; false: what is measured
  // is the points' alone.
  bool has_depth_images = false;
  unsigned seed = 0;
};

// The plane z = 2 + 0.2 x - 0.1 y in the world, with a smooth texture of many scales.
inline double PlaneTexture(double x, double y) {
  return 128 + 30 * std::sin(4.3 * x + 1.1 * y + 0.4) * std::cos(3.7 * y - 0.9 * x) +
         25 * std::sin(11 * x - 7 * y) + 22 * std::sin(23 * x + 3 * y) * std::cos(19 * y - 5 * x) +
         18 * std::sin(61 * x - 40 * y) + 16 * std::cos(97 * y + 31 * x);
}

inline PlenopticCamera SyntheticCamera(const SyntheticOptions& options) {
  PlenopticCamera lens;
  lens.focal_length = 16.748e-3;
  lens.main_lens_mla_distance = 15.893e-3;
  lens.sensor_mla_distance = 0.376e-3;
  const double f_px = 525.0 * options.width / 640;
  return PlenopticFromPinhole(
      {options.width, options.height, f_px, f_px, 0.5 * options.width, 0.5 * options.height}, lens);
}

// Metric depth z_C of the plane along the ray of a focused pixel, and the point in the world.
inline double PlaneDepth(const PlenopticProjection& camera,
                         const SE3& cam_from_world,
                         const Eigen::Vector2d& px,
                         Eigen::Vector3d* p_in_world) {
  // Points of the pixel: x_C = (m (z - f), z); the plane is linear in z.
  const Eigen::Vector2d m = (px - camera.c) * (camera.s / camera.f);
  const SE3 world_from_cam = cam_from_world.Inverse();
  const Eigen::Vector3d origin =
      world_from_cam * Eigen::Vector3d(-m.x() * camera.f, -m.y() * camera.f, 0);
  const Eigen::Vector3d direction = world_from_cam.rotation() * Eigen::Vector3d(m.x(), m.y(), 1);
  const Eigen::Vector3d normal(-0.2, 0.1, 1);
  const double z = (2 - normal.dot(origin)) / normal.dot(direction);
  *p_in_world = origin + z * direction;
  return z;
}

using Texture = std::function<double(double x, double y)>;

inline std::shared_ptr<LightFieldFrame> RenderPlane(const PlenopticProjection& camera,
                                                    const SE3& cam_from_world,
                                                    double image_noise,
                                                    std::mt19937_64* generator,
                                                    const Texture& texture = PlaneTexture) {
  std::normal_distribution<double> normal;
  auto frame = std::make_shared<LightFieldFrame>();
  ImageF image(camera.width, camera.height);
  frame->inverse_virtual_depth = ImageF(camera.width, camera.height);
  frame->sigma = ImageF(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Eigen::Vector3d p;
      const double z = PlaneDepth(camera, cam_from_world, {x, y}, &p);
      const double noise = image_noise > 0 ? image_noise * normal(*generator) : 0;
      image(x, y) = static_cast<float>(texture(p.x(), p.y()) + noise);
      frame->inverse_virtual_depth(x, y) = static_cast<float>(InverseVirtualDepth(camera, 1 / z));
      frame->sigma(x, y) = 0.004f;
    }
  }
  frame->image = BuildPyramid(std::move(image), 6);
  return frame;
}

// Keyframes at their true states with points at their true depths.
inline Window MakeSyntheticWindow(const SyntheticOptions& options) {
  std::mt19937_64 generator = SeededGenerator(options.seed, 0);
  std::normal_distribution<double> normal;
  Window window{PlenopticProjection(SyntheticCamera(options))};
  window.noise = NoiseModel(options.image_noise, 4);
  for (int i = 0; i < options.num_keyframes; ++i) {
    Vector6d tangent;
    for (int k = 0; k < 6; ++k)
      tangent(k) = (k < 3 ? 0.2 * options.baseline : 0.005) * normal(generator);
    tangent(0) += options.baseline * i;
    auto keyframe = std::make_unique<Keyframe>();
    keyframe->id = i;
    keyframe->state = FrameState(SE3::Exp(tangent), 0, 0);
    const auto frame =
        RenderPlane(window.camera, keyframe->state.pose(), options.image_noise, &generator);
    if (!options.has_depth_images) frame->sigma = ImageF(options.width, options.height, 0);
    keyframe->frame = frame;
    window.keyframes.push_back(std::move(keyframe));
  }
  std::uniform_real_distribution<double> x(8, options.width - 8), y(8, options.height - 8);
  for (int i = 0; i < options.num_points; ++i) {
    Keyframe& host = *window.keyframes[i % options.num_keyframes];
    auto point = std::make_unique<Point>();
    MakePatch(
        host.frame->image[0], {std::floor(x(generator)), std::floor(y(generator))}, &point->patch);
    Eigen::Vector3d p;
    point->rho = 1 / PlaneDepth(window.camera, host.state.pose(), point->patch.px, &p);
    point->w_measured =
        InverseVirtualDepth(window.camera, point->rho) + options.w_sigma * normal(generator);
    point->w_sigma = std::max(options.w_sigma, 1e-4);
    host.points.push_back(std::move(point));
  }
  return window;
}

// Takes the keyframes out of the window and brings them back one by one, as they come in a run;
// `came` is called with each as the newest.
template <typename Came>
void ReplayKeyframes(Window* window, const Came& came) {
  auto keyframes = std::move(window->keyframes);
  window->keyframes.clear();
  for (auto& keyframe : keyframes) {
    window->keyframes.push_back(std::move(keyframe));
    came(window);
  }
}

// Moves poses (all but the oldest), brightness and depths off their true values.
inline void PerturbWindow(double translation,
                          double rotation,
                          double relative_rho,
                          Window* window) {
  std::mt19937_64 generator = SeededGenerator(99, 0);
  std::normal_distribution<double> normal;
  for (size_t i = 0; i < window->keyframes.size(); ++i) {
    Keyframe& keyframe = *window->keyframes[i];
    Vector6d delta;
    for (int k = 0; k < 6; ++k) delta(k) = (k < 3 ? translation : rotation) * normal(generator);
    if (i > 0) {
      keyframe.state = FrameState(SE3::Exp(delta) * keyframe.state.pose(),
                                  keyframe.state.a() + 0.01 * normal(generator),
                                  keyframe.state.b() + 0.5 * normal(generator));
    }
    for (const auto& point : keyframe.points) point->rho *= 1 + relative_rho * normal(generator);
  }
}

}  // namespace prism
