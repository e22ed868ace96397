// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>

#include <opencv2/core/mat.hpp>

namespace prism {

// What goes wrong with frames in the field, put into good ones, to see how the odometry takes it.
// `image`: gray, 8 bits or float, 0 to 255. `depth`: one channel of any type, 0 where none is
// measured, in the unit of the caller.

// The exposure of one frame against the others; what exceeds 255 is clipped there.
void ScaleExposure(double gain, cv::Mat* image);

// A uniform sheet (with a little noise) before the left half of the view. No depth is measured on
// it.
void CoverHalf(std::mt19937_64* generator, cv::Mat* image, cv::Mat* depth);

// The whole lens: nearly black, with the noise of a sensor, and no depth.
void CoverLens(std::mt19937_64* generator, cv::Mat* image, cv::Mat* depth);

// A textured patch over a fifth of the view, at one depth, which moves through the image: there and
// back along an ellipse once in `period` frames.
struct MovingPatch {
  double depth = 0;  // in the unit of the depth image
  double period = 60;
  unsigned seed = 0;  // of its texture
};
void PasteMovingPatch(const MovingPatch& patch, int frame, cv::Mat* image, cv::Mat* depth);

// A fraction of the measured depths, picked at random, becomes 0.3 to 3 times what it was, evenly
// in the logarithm.
void SpoilDepth(double fraction, std::mt19937_64* generator, cv::Mat* depth);

}  // namespace prism
