// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/preparation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glog/logging.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

int BayerToGrayCode(RawPixels pixels) {
  switch (pixels) {
    // OpenCV names a pattern by the second row's second and third pixel.
    case RawPixels::kBayerRggb:
      return cv::COLOR_BayerBG2GRAY;
    case RawPixels::kBayerBggr:
      return cv::COLOR_BayerRG2GRAY;
    case RawPixels::kBayerGrbg:
      return cv::COLOR_BayerGB2GRAY;
    case RawPixels::kBayerGbrg:
      return cv::COLOR_BayerGR2GRAY;
    case RawPixels::kGray:
      break;
  }
  return -1;
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

// Mean over a lens and its neighbours at the same offset from the micro-image centre.
ImageF AverageOverNeighbours(const LensTable& lenses, const ImageF& white) {
  ImageF mean(white.width(), white.height(), 0);
  const int reach = static_cast<int>(std::ceil(lenses.radius_px()));
  const float pitch = lenses.pitch_px();
  const int lens_count = static_cast<int>(lenses.lenses().size());
  tbb::parallel_for(0, lens_count, [&](int l) {
    const Lens& lens = lenses.lenses()[l];
    std::vector<const Lens*> around;
    for (int k = -1; k < 6; ++k) {
      const float angle = static_cast<float>(k * M_PI / 3 + M_PI / 12);
      const float r = k < 0 ? 0 : pitch;
      // Two probes a direction suit both orientations of a hexagonal lattice within rounding.
      const int index = lenses.NearestLens(lens.image_x + r * std::cos(angle),
                                           lens.image_y + r * std::sin(angle));
      if (index < 0) continue;
      const Lens* other = &lenses.lenses()[index];
      if (std::find(around.begin(), around.end(), other) == around.end()) around.push_back(other);
    }
    const int x0 = static_cast<int>(std::lround(lens.image_x));
    const int y0 = static_cast<int>(std::lround(lens.image_y));
    for (int y = std::max(y0 - reach, 0); y <= std::min(y0 + reach, white.height() - 1); ++y) {
      for (int x = std::max(x0 - reach, 0); x <= std::min(x0 + reach, white.width() - 1); ++x) {
        if (lenses.colour_mask()(x, y) != lens.colour + 1) continue;
        float sum = 0;
        int count = 0;
        for (const Lens* other : around) {
          const float u = x - lens.image_x + other->image_x;
          const float v = y - lens.image_y + other->image_y;
          if (!white.view().Contains(u, v, 2)) continue;
          sum += InterpolateCubic(white, u, v);
          ++count;
        }
        mean(x, y) = count > 0 ? sum / static_cast<float>(count) : white(x, y);
      }
    }
  });
  return mean;
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
  gain_ = ImageF(width, height, 0);
  good_ = Image<uint8_t>(width, height, 0);
  filtered_ = Image<uint8_t>(width, height, 0);
  ImageF mean;
  float bright = 1;
  if (!white.empty()) {
    ImageF gray(width, height);
    ToGray(white, &gray);
    mean = AverageOverNeighbours(lenses, gray);
    std::vector<float> values(mean.data(), mean.data() + mean.size());
    auto nth =
        values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size()));
    std::nth_element(values.begin(), nth, values.end());
    bright = std::max(*nth, 1e-3f);
  }
  const float darkest = static_cast<float>(options.min_relative_white) * bright;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (lenses.colour_mask()(x, y) == 0) continue;
      if (white.empty()) {
        gain_(x, y) = 1;
      } else if (mean(x, y) >= darkest) {
        gain_(x, y) = bright / mean(x, y);
      }
    }
  }
}

void RawPreparation::ToGray(const cv::Mat& raw, ImageF* gray) {
  CHECK_EQ(raw.cols, lenses_.width());
  CHECK_EQ(raw.rows, lenses_.height());
  CHECK(raw.depth() == CV_8U || raw.depth() == CV_16U);
  const cv::Mat* source = &raw;
  if (raw.channels() == 3) {
    cv::cvtColor(raw, one_channel_, cv::COLOR_BGR2GRAY);
    source = &one_channel_;
  } else if (options_.pixels != RawPixels::kGray) {
    cv::cvtColor(raw, one_channel_, BayerToGrayCode(options_.pixels));
    source = &one_channel_;
  }
  cv::Mat target(gray->height(), gray->width(), CV_32F, gray->data());
  source->convertTo(target, CV_32F, raw.depth() == CV_8U ? 1.0 : 1.0 / 257);
}

void RawPreparation::Prepare(const cv::Mat& raw, PreparedRaw* prepared) {
  const int width = lenses_.width();
  const int height = lenses_.height();
  if (prepared->gray.empty()) {
    prepared->gray = ImageF(width, height);
    prepared->smooth = ImageF(width, height);
    prepared->lens_colour = ImageF(width, height, 0);
  }
  ToGray(raw, &prepared->gray);
  const float saturation = static_cast<float>(options_.saturation);
  tbb::parallel_for(0, height, [&](int y) {
    float* gray = prepared->gray.row(y);
    const float* gain = gain_.row(y);
    const uint8_t* colour = lenses_.colour_mask().row(y);
    uint8_t* good = good_.row(y);
    for (int x = 0; x < width; ++x) {
      const bool is_good = gray[x] < saturation && gain[x] > 0;
      good[x] = is_good ? colour[x] : uint8_t{0};
      gray[x] *= gain[x] > 0 ? gain[x] : 1.0f;
    }
  });
  tbb::parallel_for(0, height, [&](int y) {
    const uint8_t* above = good_.row(std::max(y - 1, 0));
    const uint8_t* here = good_.row(y);
    const uint8_t* below = good_.row(std::min(y + 1, height - 1));
    const float* g_above = prepared->gray.row(std::max(y - 1, 0));
    const float* g = prepared->gray.row(y);
    const float* g_below = prepared->gray.row(std::min(y + 1, height - 1));
    float* smooth = prepared->smooth.row(y);
    uint8_t* filtered_row = filtered_.row(y);
    smooth[0] = g[0];
    smooth[width - 1] = g[width - 1];
    for (int x = 1; x < width - 1; ++x) {
      const uint8_t c = here[x];
      smooth[x] = (g_above[x - 1] + g_above[x + 1] + g_below[x - 1] + g_below[x + 1] +
                   2 * (g_above[x] + g_below[x] + g[x - 1] + g[x + 1]) + 4 * g[x]) *
                  (1.0f / 16);
      const bool whole = here[x - 1] == c && here[x + 1] == c && above[x - 1] == c &&
                         above[x] == c && above[x + 1] == c && below[x - 1] == c && below[x] == c &&
                         below[x + 1] == c;
      filtered_row[x] = whole ? c : uint8_t{0};
    }
  });
  tbb::parallel_for(0, height - 1, [&](int y) {
    const uint8_t* here = filtered_.row(y);
    const uint8_t* below = filtered_.row(y + 1);
    float* lens_colour = prepared->lens_colour.row(y);
    for (int x = 0; x < width - 1; ++x) {
      const uint8_t c = here[x];
      const bool cell = here[x + 1] == c && below[x] == c && below[x + 1] == c;
      lens_colour[x] = cell ? static_cast<float>(c) : 0.0f;
    }
  });
}

}  // namespace prism
