// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/preparation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glog/logging.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "prism/lightfield/colour_mosaic.h"
#include "prism/lightfield/patch_kernel.h"

namespace prism {
namespace {

// Noise of SmoothRows::smooth made of a mosaic (bilinear interpolation, weights of gray 0.30,
// 0.59, 0.11) over that of white noise as large as the mosaic's.
constexpr double kDemosaicedNoise = 0.843;

// Of cv::cvtColor.
struct DemosaicCodes {
  int gray, bgr;
};

DemosaicCodes DemosaicCodesOf(RawPixels pixels) {
  switch (pixels) {
    // OpenCV names a pattern by the second row's second and third pixel.
    case RawPixels::kBayerRggb:
      return {cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR};
    case RawPixels::kBayerBggr:
      return {cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR};
    case RawPixels::kBayerGrbg:
      return {cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR};
    case RawPixels::kBayerGbrg:
      return {cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR};
    case RawPixels::kGray:
      break;
  }
  return {-1, -1};
}

// Catmull-Rom: bilinear values would flatten the steep rim of a micro image.
float InterpolateCubic(const ImageF& image, float x, float y) {
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const auto weights = [](float t, float* w) {
    w[0] = t * (-0.5f + t * (1 - 0.5f * t));
    w[1] = 1 + t * t * (-2.5f + 1.5f * t);
    w[2] = t * (0.5f + t * (2 - 1.5f * t));
    w[3] = t * t * (-0.5f + 0.5f * t);
  };
  float wx[4], wy[4];
  weights(x - static_cast<float>(x0), wx);
  weights(y - static_cast<float>(y0), wy);
  float sum = 0;
  for (int j = 0; j < 4; ++j) {
    const float* p = image.row(y0 - 1 + j) + x0 - 1;
    sum += wy[j] * (wx[0] * p[0] + wx[1] * p[1] + wx[2] * p[2] + wx[3] * p[3]);
  }
  return sum;
}

// Mean over a lens and its nearest neighbours of the same type at the same offset from the
// micro-image centre. Types differ in the width of their penumbra.
ImageF AverageOverNeighbours(const LensTable& lenses, const ImageF& white) {
  ImageF mean(white.width(), white.height(), 0);
  const int lens_count = static_cast<int>(lenses.lenses().size());
  constexpr float kReach = 1.8f;  // pitches; with three types the nearest alike are 1.73 away
  constexpr size_t kAveraged = 7;
  tbb::parallel_for(0, lens_count, [&](int l) {
    const Lens& lens = lenses.lenses()[l];
    std::vector<const Lens*> alike = {&lens};
    for (const int other : lenses.NeighboursOf(l, kReach * lenses.pitch_px())) {
      if (lenses.lenses()[other].type == lens.type && alike.size() < kAveraged) {
        alike.push_back(&lenses.lenses()[other]);
      }
    }
    lenses.ForEachPixel(lens, [&](int x, int y) {
      float sum = 0;
      int count = 0;
      for (const Lens* other : alike) {
        const float u = x - lens.image_x + other->image_x;
        const float v = y - lens.image_y + other->image_y;
        if (!white.view().Contains(u, v, 2)) continue;
        sum += InterpolateCubic(white, u, v);
        ++count;
      }
      mean(x, y) = count > 0 ? sum / static_cast<float>(count) : white(x, y);
    });
  });
  return mean;
}

// The value that `share` of all values are below.
float Percentile(double share, std::vector<float>* values) {
  const auto nth = values->begin() +
                   static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), nth, values->end());
  return *nth;
}

// Where all nine pixels around one belong to one micro image.
void InteriorRow(const Image<uint8_t>& good, int y, uint8_t* interior) {
  const uint8_t *above = good.row(std::max(y - 1, 0)), *here = good.row(y);
  const uint8_t* below = good.row(std::min(y + 1, good.height() - 1));
  for (int x = 1; x < good.width() - 1; ++x) {
    const uint8_t c = here[x];
    // No branches: the loop is vectorised.
    const int differs = (here[x - 1] ^ c) | (here[x + 1] ^ c) | (above[x - 1] ^ c) |
                        (above[x] ^ c) | (above[x + 1] ^ c) | (below[x - 1] ^ c) | (below[x] ^ c) |
                        (below[x + 1] ^ c);
    interior[x] = differs == 0 ? c : uint8_t{0};
  }
}

// Where bilinear interpolation in [x, x+1] x [y, y+1] uses pixels of one micro image.
void CellColourRow(const Image<uint8_t>& good, int y, uint8_t* colour) {
  if (y + 1 == good.height()) return;  // stays 0
  const uint8_t *here = good.row(y), *below = good.row(y + 1);
  for (int x = 0; x < good.width() - 1; ++x) {
    const uint8_t c = here[x];
    const int differs = (here[x + 1] ^ c) | (below[x] ^ c) | (below[x + 1] ^ c);
    colour[x] = differs == 0 ? c : uint8_t{0};
  }
}

// Values of 0 to 255.
void GrayRow(const cv::Mat& image, int y, float* gray) {
  if (image.depth() == CV_8U) {
    const uint8_t* row = image.ptr<uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) gray[x] = row[x];
  } else {
    const uint16_t* row = image.ptr<uint16_t>(y);
    for (int x = 0; x < image.cols; ++x) gray[x] = static_cast<float>(row[x]) * (1.0f / 257);
  }
}

void ApplyGain(const float* gain, int width, float* row) {
  for (int x = 0; x < width; ++x) row[x] *= gain[x] > 0 ? gain[x] : 1.0f;
}

}  // namespace

bool PreparationOptions::IsValid(std::string* error) const {
  if (!(min_relative_white >= 0 && min_relative_white < 1)) {
    *error = "min_relative_white of " + std::to_string(min_relative_white) + ", expected 0 to 1";
    return false;
  }
  if (!(saturation > 0)) {
    *error = "saturation of " + std::to_string(saturation) + ", expected > 0";
    return false;
  }
  return true;
}

RawPreparation::RawPreparation(const LensTable& lenses,
                               const cv::Mat& white,
                               const PreparationOptions& options)
    : lenses_(lenses), options_(options) {
  const int width = lenses.width();
  const int height = lenses.height();
  good_ = Image<uint8_t>(width, height, 0);
  filtered_ = Image<uint8_t>(width, height, 0);
  if (lenses.HasSeveralFocalLengths()) filtered_twice_ = Image<uint8_t>(width, height, 0);
  gain_ = ImageF(width, height, 0);
  if (white.empty()) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) gain_(x, y) = lenses.colour_mask()(x, y) != 0 ? 1.0f : 0.0f;
    }
    return;
  }
  ImageF gray(width, height);
  const cv::Mat& image = OneChannel(white);
  for (int y = 0; y < height; ++y) GrayRow(image, y, gray.row(y));
  MeasureVignetting(AverageOverNeighbours(lenses, gray));
}

void RawPreparation::MeasureVignetting(const ImageF& white) {
  constexpr double kBright = 0.99;    // share of all pixels that are darker than the bright level
  constexpr double kUnshaded = 0.9;   // the same within a micro image
  constexpr float kDarkLens = 0.05f;  // of the bright level: outside the main lens' image circle
  std::vector<float> all(white.data(), white.data() + white.size());
  const float bright = std::max(Percentile(kBright, &all), 1e-3f);
  const float most_shaded = static_cast<float>(options_.min_relative_white);
  tbb::parallel_for(size_t{0}, lenses_.lenses().size(), [&](size_t l) {
    const Lens& lens = lenses_.lenses()[l];
    std::vector<float> values;
    lenses_.ForEachPixel(lens, [&](int x, int y) { values.push_back(white(x, y)); });
    if (values.empty()) return;
    const float level = Percentile(kUnshaded, &values);
    if (level < kDarkLens * bright) return;
    lenses_.ForEachPixel(lens, [&](int x, int y) {
      if (white(x, y) >= most_shaded * level) gain_(x, y) = bright / white(x, y);
    });
  });
}

// Overwrites good_ and filtered_, which belong to no frame yet.
void RawPreparation::SumGainSlopes(PreparedRaw* prepared) {
  const int width = lenses_.width();
  const int height = lenses_.height();
  prepared->gain_slope_x = ImageF(width, height, 0);
  prepared->gain_slope_y = ImageF(width, height, 0);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      good_(x, y) = gain_(x, y) > 0 ? lenses_.colour_mask()(x, y) : uint8_t{0};
    }
  });
  tbb::parallel_for(0, height, [&](int y) { InteriorRow(good_, y, filtered_.row(y)); });
  const cv::Mat gain(height, width, CV_32F, gain_.data());
  const cv::Mat good(height, width, CV_8U, good_.data());
  const cv::Mat interior(height, width, CV_8U, filtered_.data());
  const cv::Mat weights(1, 2 * kPatchRadius + 1, CV_32F, const_cast<float*>(kPatchWeights));
  const auto sum = [&](const cv::Mat& along_x, const cv::Mat& along_y, ImageF* sums) {
    cv::Mat slope, slope_of_colour, sum_of_colour;
    cv::sepFilter2D(gain, slope, CV_32F, along_x, along_y);
    cv::Mat target(height, width, CV_32F, sums->data());
    // Of the pixels of the micro image that the patch's centre lies in.
    for (const int colour : {1, 2, 3}) {
      slope_of_colour = cv::Mat::zeros(height, width, CV_32F);
      slope.copyTo(slope_of_colour, interior == colour);
      cv::sepFilter2D(slope_of_colour,
                      sum_of_colour,
                      CV_32F,
                      weights,
                      weights,
                      cv::Point(-1, -1),
                      0,
                      cv::BORDER_CONSTANT);
      sum_of_colour.copyTo(target, good == colour);
    }
  };
  const cv::Mat difference = (cv::Mat_<float>(1, 3) << -0.5f, 0, 0.5f);
  const cv::Mat same = (cv::Mat_<float>(1, 1) << 1);
  sum(difference, same, &prepared->gain_slope_x);
  sum(same, difference, &prepared->gain_slope_y);
}

const cv::Mat& RawPreparation::OneChannel(const cv::Mat& raw) {
  CHECK_EQ(raw.cols, lenses_.width());
  CHECK_EQ(raw.rows, lenses_.height());
  CHECK(raw.depth() == CV_8U || raw.depth() == CV_16U);
  if (raw.channels() == 3) {
    cv::cvtColor(raw, one_channel_, cv::COLOR_BGR2GRAY);
  } else if (options_.pixels != RawPixels::kGray) {
    cv::cvtColor(raw, one_channel_, DemosaicCodesOf(options_.pixels).gray);
  } else {
    return raw;
  }
  return one_channel_;
}

cv::Mat RawPreparation::ToBgr(const cv::Mat& raw) const {
  if (raw.channels() == 3) return raw;
  if (options_.pixels == RawPixels::kGray) return {};
  cv::Mat bgr;
  cv::cvtColor(raw, bgr, DemosaicCodesOf(options_.pixels).bgr);
  return bgr;
}

void RawPreparation::PrepareChannel(const cv::Mat& bgr, int channel, ImageF* corrected) const {
  if (corrected->empty()) *corrected = ImageF(bgr.cols, bgr.rows);
  cv::Mat values;
  cv::extractChannel(bgr, values, channel);
  tbb::parallel_for(0, bgr.rows, [&](int y) {
    GrayRow(values, y, corrected->row(y));
    ApplyGain(gain_.row(y), bgr.cols, corrected->row(y));
  });
}

void RawPreparation::Prepare(const cv::Mat& raw, PreparedRaw* prepared) {
  const int width = lenses_.width();
  const int height = lenses_.height();
  if (prepared->gray.empty()) {
    prepared->gray = ImageF(width, height);
    prepared->lens_colour = Image<uint8_t>(width, height, 0);
    SumGainSlopes(prepared);
    if (lenses_.HasSeveralFocalLengths()) {
      prepared->lens_colour_smoother = Image<uint8_t>(width, height, 0);
    }
  }
  const cv::Mat& image = OneChannel(raw);
  if (options_.pixels != RawPixels::kGray) {
    const cv::Mat gain(height, width, CV_32F, gain_.data());
    prepared->mosaic_noise = kDemosaicedNoise * MosaicNoise(raw, gain);
  }
  // Masks change with the pixels that are saturated, in this frame or in the last, alone.
  if (prepared != last_prepared_) has_masked_.assign(height, true);
  last_prepared_ = prepared;
  was_masked_.swap(has_masked_);
  has_masked_.assign(height, false);
  const float saturation = static_cast<float>(options_.saturation);
  tbb::parallel_for(0, height, [&](int y) {
    float* gray = prepared->gray.row(y);
    GrayRow(image, y, gray);
    has_masked_[y] = *std::max_element(gray, gray + width) >= saturation;
    const float* gain = gain_.row(y);
    if (has_masked_[y] || was_masked_[y]) {
      const uint8_t* colour = lenses_.colour_mask().row(y);
      uint8_t* good = good_.row(y);
      for (int x = 0; x < width; ++x) {
        const bool is_good = gray[x] < saturation && gain[x] > 0;
        good[x] = is_good ? colour[x] : uint8_t{0};
      }
    }
    ApplyGain(gain, width, gray);
  });
  ForRowsAround(1, [&](int y) { InteriorRow(good_, y, filtered_.row(y)); });
  ForRowsAround(2, [&](int y) { CellColourRow(filtered_, y, prepared->lens_colour.row(y)); });
  if (!lenses_.HasSeveralFocalLengths()) return;
  ForRowsAround(2, [&](int y) { InteriorRow(filtered_, y, filtered_twice_.row(y)); });
  ForRowsAround(
      3, [&](int y) { CellColourRow(filtered_twice_, y, prepared->lens_colour_smoother.row(y)); });
}

template <typename Row>
void RawPreparation::ForRowsAround(int reach, const Row& row) const {
  const int height = lenses_.height();
  tbb::parallel_for(0, height, [&](int y) {
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height - 1); ++v) {
      if (has_masked_[v] || was_masked_[v]) return row(y);
    }
  });
}

}  // namespace prism
