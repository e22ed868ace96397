// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/image/image.h"
#include "prism/lightfield/lens_table.h"

namespace prism {

// What the pixels of a one-channel raw image are. The name is the colours of the top-left 2 x 2
// pixels, row by row.
enum class RawPixels { kGray, kBayerRggb, kBayerBggr, kBayerGrbg, kBayerGbrg };

struct PreparationOptions {
  RawPixels pixels = RawPixels::kGray;
  double min_relative_white = 0.75;  // darker in the white image than this share of what its micro
                                     // image is at the brightest: masked
  double saturation = 250;           // 0 to 255; brighter raw pixels are masked

  bool IsValid(std::string* error) const;
};

// A raw image ready for matching and resampling, 0 to 255 in raw px.
struct PreparedRaw {
  ImageF gray;  // vignetting-corrected
  // Of a Bayer mosaic: the standard deviation of white noise in `gray` that would give its
  // SmoothRows the noise they have. Interpolation hides noise from whoever looks at `gray` alone.
  // 0: no mosaic.
  double mosaic_noise = 0;
  // Colour + 1 of the lens (LensTable) if bilinear interpolation of SmoothRows::smooth in
  // [x, x+1] x [y, y+1] comes from good pixels of that micro image alone, else 0. A filter with
  // fewer pixels at the rim would shift the image inwards and bias the depth.
  Image<uint8_t> lens_colour;
  // The same of SmoothRows::smoother, for arrays of several focal lengths, else empty.
  Image<uint8_t> lens_colour_smoother;
  // Gradient of the vignetting's gain in x and in y, the weighted sum over the pixels of a patch
  // (kPatchWeights) that are good in the white image, by the patch's centre, in kGainSlopeUnit /
  // px. Empty without a white image.
  Image<int16_t> gain_slope_x, gain_slope_y;
};

inline constexpr float kGainSlopeUnit = 1.0f / 512;

// Demosaicing, conversion to gray, vignetting, masks.
//
// The white image is averaged over each lens and its nearest neighbours of the same type at the
// same place in the micro image, which takes its noise away and keeps the vignetting; the gain is
// its bright level (the 99th percentile) over that mean. Pixels that are dark in the white image,
// beside the rest of their micro image, or saturated in the frame are masked and not amplified.
class RawPreparation {
 public:
  // `white` may be empty (frames corrected already): gain 1. Else it has the size of the camera's
  // raw image, 8 or 16 bits, 1 or 3 channels. `lenses` must outlive this.
  RawPreparation(const LensTable& lenses, const cv::Mat& white, const PreparationOptions& options);

  // Precondition: the image has the camera's size, 8 or 16 bits, 1 or 3 channels (1 if Bayer).
  void Prepare(const cv::Mat& raw, PreparedRaw* prepared);

  // Such an image as BGR: itself, or demosaiced; empty if it is gray.
  cv::Mat ToBgr(const cv::Mat& raw) const;
  // One channel of that, 0 to 255, vignetting-corrected as PreparedRaw::gray is.
  void PrepareChannel(const cv::Mat& bgr, int channel, ImageF* corrected) const;

 private:
  // Such an image in gray, without a copy if it is.
  const cv::Mat& OneChannel(const cv::Mat& raw);
  void MeasureVignetting(const ImageF& white);
  void SumGainSlopes(PreparedRaw* prepared) const;
  // Lens colours of rows begin to end - 1 of `image`.
  void MaskRows(const cv::Mat& image, int begin, int end, PreparedRaw* prepared) const;
  // Whether masks of rows begin to end - 1 may differ from those of the last frame.
  bool MasksChange(int begin, int end) const;

  const LensTable& lenses_;
  PreparationOptions options_;
  ImageF gain_;  // 0: masked
  bool has_white_;
  cv::Mat one_channel_;
  // Rows of the last frame and of the one before with pixels masked that are good in the white
  // image. Of all rows as long as nothing is known of `last_prepared_`.
  std::vector<char> has_masked_, was_masked_;
  const PreparedRaw* last_prepared_ = nullptr;
};

}  // namespace prism
