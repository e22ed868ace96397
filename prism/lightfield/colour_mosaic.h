// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace prism {

// What the pixels of a one-channel image are, as far as the image tells.
enum class Mosaic {
  kNone,                    // gray
  kGreenOnMainDiagonal,     // of each 2 x 2 pixels, top left and bottom right: GRBG or GBRG
  kGreenOnOtherDiagonal,    // RGGB or BGGR
  kGreenOnUnknownDiagonal,  // a mosaic of a scene in which red and blue are alike
};

// Compares the four pixels of 2 x 2 in blocks of 16 x 16. In a gray image they differ alike; in a
// Bayer mosaic the two green ones are alike and the others are not, or both green ones differ from
// both others. Mosaics of scenes without colour, balanced so that all channels are alike, cannot be
// told from gray ones: kNone. Precondition: 8 or 16 bits, one channel, 64 x 64 pixels or more.
Mosaic FindMosaic(const cv::Mat& image);

// Standard deviation of the noise of a Bayer mosaic, 0 to 255: of the differences between pixels of
// one colour, their lower quartile, in the direction that shows less of the scene. `gain` (0: left
// out) is what each pixel is amplified by and has the image's size. 0 if there is nothing to tell
// it from.
double MosaicNoise(const cv::Mat& mosaic, const cv::Mat& gain);

}  // namespace prism
