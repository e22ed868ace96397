// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/scene/frame.h"

namespace prism {

// What frames tell of the three lattices of lenses that a hexagonal array is coloured with.
struct LensTypeFit {
  std::vector<MicroLensType> types;  // one, or three with their ranges of virtual depth
  double evidence = 1;               // for three types, see below
  bool focus_measured = false;       // else `types` have the ranges assumed
  std::array<double, 3> focus{};     // 1/v that each type is sharpest at, as measured
  double focus_sigma = 0;            // of the least certain of them
};

// Whether the micro lenses have one focal length or three, which lens has which, and what each is
// focused on.
//
// 1. Up to three of the frames are processed with each order of three types with ranges as Raytrix
// arrays have
//    them (1 to 3.2, 2.6 to 4.2, 3.5 to 100). To an array of one type all orders are the same; of
//    three types those that compare lenses of like blur find more depth. `evidence` is the
//    information (CameraTrial) of the best over that of the worst; below 1.2 there is one type.
//    Else the order is that of the sharpest focused image.
// 2. With it the frames are processed, and at each pixel with a depth the squared gradients of the
//    raw image around its views (less that of the noise) are summed by type and by 1/v. Out of
//    focus by 1/v - f_k a lens adds DefocusVariance (1/v - f_k)^2 to the blur of all, s^2, and of a
//    picture whose edges have no preferred size there remains
//        E_k(1/v) = A(1/v) / (s^2 + DefocusVariance (1/v - f_k)^2),
//    which is fitted for f_k and s^2. Where the frames hold enough different depths to tell, and
//    the focused image does not become less sharp by it, each type gets the range around its f_k.
//
// Preconditions: `camera` has a hexagonal grid; at least one frame, all of its raw size.
LensTypeFit EstimateLensTypes(const PlenopticCamera& camera,
                              const cv::Mat& white,
                              const LightFieldOptions& options,
                              const std::vector<RawFrame>& frames);

}  // namespace prism
