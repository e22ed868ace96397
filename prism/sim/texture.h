// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace prism {

using Rgb = Eigen::Array3f;  // linear radiance or reflectance, red first

// An image looked up with a footprint: trilinear in a pyramid of halved images. Repeats beyond
// [0, 1).
class Texture {
 public:
  // 8-bit BGR (as OpenCV decodes) or gray. Precondition: not empty.
  explicit Texture(const cv::Mat& image);

  // u to the right, v down, in texture widths and heights; footprint is the side of the square that
  // the sample stands for, in texture widths. Values 0 to 1.
  Rgb Sample(float u, float v, float footprint) const;

 private:
  std::vector<cv::Mat> levels_;  // CV_8UC4, BGR and a byte of padding
};

}  // namespace prism
