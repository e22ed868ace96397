// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/reprojection.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "prism/image/interpolation.h"

namespace prism {
namespace {

constexpr int kReach = 2;              // focused px without a depth edge
constexpr float kMaxRange = 0.01f;     // of 1/v
constexpr int kIterations = 4;         // of X and w(X)
constexpr float kStartDepth = 0.35f;   // 1/v
constexpr float kMaxLastStep = 0.05f;  // focused px

// Whether 1/v is measured at a focused pixel and has no edge around it.
bool IsSmooth(const ImageF& depth, int x, int y) {
  if (x < kReach || y < kReach || x >= depth.width() - kReach || y >= depth.height() - kReach ||
      depth(x, y) == 0) {
    return false;
  }
  float low = depth(x, y), high = low;
  for (int v = y - kReach; v <= y + kReach; ++v) {
    for (int u = x - kReach; u <= x + kReach; ++u) {
      if (depth(u, v) == 0) continue;
      low = std::min(low, depth(u, v));
      high = std::max(high, depth(u, v));
    }
  }
  return high - low <= kMaxRange;
}

}  // namespace

ReprojectionError MeasureReprojection(const PlenopticCamera& camera,
                                      const LensTable& lenses,
                                      const PreparedRaw& raw,
                                      const LightFieldFrame& frame,
                                      const ImageF& dense,
                                      double min_gradient) {
  const ImageF& image = frame.image[0];
  const float scale = static_cast<float>(camera.focused_scale);
  ReprojectionError error;
  double sum = 0;
  for (const Lens& lens : lenses.lenses()) {
    Eigen::Matrix2f distortion;
    distortion << lens.axx, lens.axy, lens.ayx, lens.ayy;
    const Eigen::Matrix2f undistort = distortion.inverse();
    const Eigen::Vector2f center(lens.lens_x, lens.lens_y);
    lenses.ForEachPixel(lens, [&](int x, int y) {
      if (raw.lens_colour(x, y) != lens.colour + 1) return;
      const Eigen::Vector2f from_image_center(static_cast<float>(x) - lens.image_x,
                                              static_cast<float>(y) - lens.image_y);
      const Eigen::Vector2f p =
          Eigen::Vector2f(lens.center_x, lens.center_y) + undistort * from_image_center;
      float w = kStartDepth;
      Eigen::Vector2f focused = Eigen::Vector2f::Zero();
      float last_step = 0;
      for (int iteration = 0; iteration < kIterations; ++iteration) {
        const Eigen::Vector2f X = (p - center) / lenses.Magnification(w) + center;
        const Eigen::Vector2f next = (lenses.PixelOf(X, w).array() + 0.5f) / scale - 0.5f;
        last_step = (next - focused).norm();
        focused = next;
        if (!image.view().Contains(focused.x(), focused.y(), 1)) break;
        w = dense(static_cast<int>(std::lround(focused.x())),
                  static_cast<int>(std::lround(focused.y())));
      }
      if (last_step > kMaxLastStep || !image.view().Contains(focused.x(), focused.y(), 1) ||
          !IsSmooth(frame.inverse_virtual_depth,
                    static_cast<int>(std::lround(focused.x())),
                    static_cast<int>(std::lround(focused.y())))) {
        return;
      }
      const auto sample = InterpolateBilinear(image, focused.x(), focused.y());
      if (std::hypot(sample.dx, sample.dy) < min_gradient) return;
      const double residual = raw.gray(x, y) - sample.value;
      sum += residual * residual;
      ++error.pixels;
    });
  }
  if (error.pixels > 0) error.rms = std::sqrt(sum / static_cast<double>(error.pixels));
  return error;
}

}  // namespace prism
