// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/geometry/se3.h"
#include "prism/image/image.h"
#include "prism/sim/plenoptic_optics.h"
#include "prism/sim/ray_caster.h"

namespace prism {

struct RenderOptions {
  int samples = 4;    // rays a raw pixel, over its area, its micro lens and the exposure
  uint64_t seed = 1;  // of the sample positions

  bool IsValid(std::string* error) const;
};

// The raw image before a uniform white surface of radiance 1, CV_32FC1: the share of the light that
// reaches each pixel, in closed form. It is the same for all frames of a camera.
cv::Mat RenderWhite(const PlenopticOptics& optics);

// The raw image of a plenoptic camera: for each pixel what gets through (`white`, RenderWhite of
// the same optics) times the mean radiance of `samples` rays that the main lens does not block,
// CV_32FC3, BGR. A uniform surface is therefore flat after division by the white image, however few
// the samples. `world_from_cam` holds the camera's poses at equally spaced moments of the exposure
// (one: no motion blur). The image depends on (seed, frame) and not on the number of threads.
cv::Mat RenderRaw(const RayCaster& caster,
                  const PlenopticOptics& optics,
                  const cv::Mat& white,
                  const std::vector<SE3>& world_from_cam,
                  const RenderOptions& options,
                  uint64_t frame);

// What a conventional camera with an entrance pupil of no extent sees from the same place:
// PinholeView(camera) reduced by `reduction`, radiance, CV_32FC3, BGR.
cv::Mat RenderPreview(const RayCaster& caster,
                      const PlenopticCamera& camera,
                      const SE3& world_from_cam,
                      const RenderOptions& options,
                      int reduction = 1);

struct DepthTruth {
  ImageF inverse_virtual_depth;  // 1/v on the focused grid; 0 where nothing is hit
  ImageF depth;                  // z_C, m; 0 where nothing is hit
};

// True depth of the pixels of the focused image. Light that ends in x'_V comes along the line
// through the front focal point (0, 0, f_L) with slope (x'_V - c) s / f_L (Eqs. (10), (17)); the
// first surface beyond f_L counts. 1/v from depth by Eqs. (2) and (4).
DepthTruth RenderDepthTruth(const RayCaster& caster,
                            const PlenopticCamera& camera,
                            const SE3& world_from_cam);

}  // namespace prism
