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

// Where all nine pixels around one belong to one micro image. The first and the last stay as they
// are.
void InteriorRow(
    const uint8_t* above, const uint8_t* here, const uint8_t* below, int width, uint8_t* interior) {
  for (int x = 1; x < width - 1; ++x) {
    const uint8_t c = here[x];
    // No branches: the loop is vectorised.
    const int differs = (here[x - 1] ^ c) | (here[x + 1] ^ c) | (above[x - 1] ^ c) |
                        (above[x] ^ c) | (above[x + 1] ^ c) | (below[x - 1] ^ c) | (below[x] ^ c) |
                        (below[x + 1] ^ c);
    interior[x] = differs == 0 ? c : uint8_t{0};
  }
}

// Where bilinear interpolation in [x, x+1] x [y, y+1] uses pixels of one micro image.
void CellColourRow(const uint8_t* here, const uint8_t* below, int width, uint8_t* colour) {
  for (int x = 0; x < width - 1; ++x) {
    const uint8_t c = here[x];
    const int differs = (here[x + 1] ^ c) | (below[x] ^ c) | (below[x + 1] ^ c);
    colour[x] = differs == 0 ? c : uint8_t{0};
  }
}

// Rows begin to end - 1 of a mask, as far as they are within an image of `height` rows.
class MaskBand {
 public:
  MaskBand(int width, int height, int begin, int end)
      : height_(height),
        begin_(std::max(begin, 0)),
        end_(std::min(end, height)),
        rows_(width, end_ - begin_, 0) {}

  int begin() const { return begin_; }
  int end() const { return end_; }
  uint8_t* row(int y) { return rows_.row(y - begin_); }

  // Of a band that reaches one row further.
  void SetToInteriorOf(MaskBand* mask) {
    for (int y = begin_; y < end_; ++y) {
      InteriorRow(mask->row(std::max(y - 1, 0)),
                  mask->row(y),
                  mask->row(std::min(y + 1, height_ - 1)),
                  rows_.width(),
                  row(y));
    }
  }

 private:
  int height_, begin_, end_;
  Image<uint8_t> rows_;
};

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
    : lenses_(lenses), options_(options), has_white_(!white.empty()) {
  const int width = lenses.width();
  const int height = lenses.height();
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

void RawPreparation::SumGainSlopes(PreparedRaw* prepared) const {
  constexpr int kBand = 256;  // rows at once: what is in between takes 20 bytes a pixel
  const int width = lenses_.width();
  const int height = lenses_.height();
  prepared->gain_slope_x = Image<int16_t>(width, height, 0);
  prepared->gain_slope_y = Image<int16_t>(width, height, 0);
  const cv::Mat all_gain(height, width, CV_32F, const_cast<float*>(gain_.data()));
  const cv::Mat weights(1, 2 * kPatchRadius + 1, CV_32F, const_cast<float*>(kPatchWeights));
  const cv::Mat difference = (cv::Mat_<float>(1, 3) << -0.5f, 0, 0.5f);
  const cv::Mat same = (cv::Mat_<float>(1, 1) << 1);
  for (int begin = 0; begin < height; begin += kBand) {
    const int end = std::min(begin + kBand, height);
    // Slopes are summed over a patch, and found on pixels with good ones around them.
    const int first = std::max(begin - kPatchRadius, 0);
    const int last = std::min(end + kPatchRadius, height);
    const int top = std::max(first - 1, 0);
    Image<uint8_t> good(width, std::min(last + 1, height) - top);
    tbb::parallel_for(0, good.height(), [&](int y) {
      for (int x = 0; x < width; ++x) {
        good(x, y) = gain_(x, top + y) > 0 ? lenses_.colour_mask()(x, top + y) : uint8_t{0};
      }
    });
    Image<uint8_t> interior(width, last - first, 0);
    tbb::parallel_for(first, last, [&](int y) {
      InteriorRow(good.row(std::max(y - 1, 0) - top),
                  good.row(y - top),
                  good.row(std::min(y + 1, height - 1) - top),
                  width,
                  interior.row(y - first));
    });
    const cv::Mat gain = all_gain.rowRange(first, last);
    const cv::Mat interior_view(last - first, width, CV_8U, interior.data());
    const cv::Mat good_view(end - begin, width, CV_8U, good.row(begin - top));
    const auto sum = [&](const cv::Mat& along_x, const cv::Mat& along_y, Image<int16_t>* sums) {
      cv::Mat slope, slope_of_colour, sum_of_colour, rounded;
      cv::sepFilter2D(gain, slope, CV_32F, along_x, along_y);
      cv::Mat target(end - begin, width, CV_16S, sums->row(begin));
      // Of the pixels of the micro image that the patch's centre lies in.
      for (const int colour : {1, 2, 3}) {
        slope_of_colour = cv::Mat::zeros(slope.size(), CV_32F);
        slope.copyTo(slope_of_colour, interior_view == colour);
        cv::sepFilter2D(slope_of_colour.rowRange(begin - first, end - first),
                        sum_of_colour,
                        CV_32F,
                        weights,
                        weights,
                        cv::Point(-1, -1),
                        0,
                        cv::BORDER_CONSTANT);
        sum_of_colour.convertTo(rounded, CV_16S, 1 / kGainSlopeUnit);
        rounded.copyTo(target, good_view == colour);
      }
    };
    sum(difference, same, &prepared->gain_slope_x);
    sum(same, difference, &prepared->gain_slope_y);
  }
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
    if (has_white_) SumGainSlopes(prepared);
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
    ApplyGain(gain_.row(y), width, gray);
  });
  constexpr int kRowsAtOnce = 16;
  tbb::parallel_for(0, (height + kRowsAtOnce - 1) / kRowsAtOnce, [&](int part) {
    const int begin = part * kRowsAtOnce;
    const int end = std::min(begin + kRowsAtOnce, height);
    if (MasksChange(begin, end)) MaskRows(image, begin, end, prepared);
  });
}

bool RawPreparation::MasksChange(int begin, int end) const {
  constexpr int kReach = 3;  // of two filters and bilinear interpolation
  for (int y = std::max(begin - kReach, 0); y < std::min(end + kReach, lenses_.height()); ++y) {
    if (has_masked_[y] || was_masked_[y]) return true;
  }
  return false;
}

void RawPreparation::MaskRows(const cv::Mat& image,
                              int begin,
                              int end,
                              PreparedRaw* prepared) const {
  const int width = lenses_.width();
  const int height = lenses_.height();
  const float saturation = static_cast<float>(options_.saturation);
  const auto write = [&](MaskBand* mask, Image<uint8_t>* colours) {
    for (int y = begin; y < std::min(end, height - 1); ++y) {  // the last row stays 0
      CellColourRow(mask->row(y), mask->row(y + 1), width, colours->row(y));
    }
  };
  MaskBand good(width, height, begin - 2, end + 3);
  std::vector<float> gray(width);
  for (int y = good.begin(); y < good.end(); ++y) {
    GrayRow(image, y, gray.data());
    const float* gain = gain_.row(y);
    const uint8_t* colour = lenses_.colour_mask().row(y);
    uint8_t* row = good.row(y);
    for (int x = 0; x < width; ++x) {
      const bool is_good = gray[x] < saturation && gain[x] > 0;
      row[x] = is_good ? colour[x] : uint8_t{0};
    }
  }
  MaskBand filtered(width, height, begin - 1, end + 2);
  filtered.SetToInteriorOf(&good);
  write(&filtered, &prepared->lens_colour);
  if (!lenses_.HasSeveralFocalLengths()) return;
  MaskBand filtered_twice(width, height, begin, end + 1);
  filtered_twice.SetToInteriorOf(&filtered);
  write(&filtered_twice, &prepared->lens_colour_smoother);
}

}  // namespace prism
