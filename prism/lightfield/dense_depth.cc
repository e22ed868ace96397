// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/dense_depth.h"

#include <algorithm>

#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

// Mean of up to four children, ValueAt and WeightAt giving those of the finer level.
template <typename ValueAt, typename WeightAt>
void Pull(int width,
          int height,
          const ValueAt& value_at,
          const WeightAt& weight_at,
          ImageF* value,
          ImageF* weight) {
  tbb::parallel_for(0, value->height(), [&](int y) {
    for (int x = 0; x < value->width(); ++x) {
      float sum = 0;
      float total = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, height); ++v) {
        for (int u = 2 * x; u < std::min(2 * x + 2, width); ++u) {
          const float w = weight_at(u, v);
          sum += w * value_at(u, v);
          total += w;
        }
      }
      (*value)(x, y) = total > 0 ? sum / total : 0;
      (*weight)(x, y) = total;
    }
  });
}

// Twice the size, bilinear. A finer level with an odd side has a pixel less than that.
cv::Mat Upsample(const ImageF& coarse) {
  const cv::Mat view(coarse.height(), coarse.width(), CV_32F, const_cast<float*>(coarse.data()));
  cv::Mat fine;
  cv::resize(view, fine, {}, 2, 2, cv::INTER_LINEAR);
  return fine;
}

}  // namespace

void DenseDepth::Fill(const ImageF& inverse_virtual_depth,
                      const ImageF& sigma,
                      float fallback,
                      ImageF* dense) {
  const int width = inverse_virtual_depth.width();
  const int height = inverse_virtual_depth.height();
  if (levels_.empty() || levels_[0].value.width() != (width + 1) / 2 ||
      levels_[0].value.height() != (height + 1) / 2) {
    levels_.clear();
    for (int w = width, h = height; w > 1 || h > 1;) {
      w = (w + 1) / 2;
      h = (h + 1) / 2;
      levels_.push_back({ImageF(w, h), ImageF(w, h)});
    }
  }
  if (dense->width() != width || dense->height() != height) *dense = ImageF(width, height);
  if (levels_.empty()) {
    (*dense)(0, 0) = sigma(0, 0) > 0 ? inverse_virtual_depth(0, 0) : fallback;
    return;
  }
  Pull(
      width,
      height,
      [&](int x, int y) { return inverse_virtual_depth(x, y); },
      [&](int x, int y) { return sigma(x, y) > 0 ? 1e-6f / (sigma(x, y) * sigma(x, y)) : 0.0f; },
      &levels_[0].value,
      &levels_[0].weight);
  for (size_t l = 1; l < levels_.size(); ++l) {
    const Level& fine = levels_[l - 1];
    Pull(
        fine.value.width(),
        fine.value.height(),
        [&](int x, int y) { return fine.value(x, y); },
        [&](int x, int y) { return fine.weight(x, y); },
        &levels_[l].value,
        &levels_[l].weight);
  }
  if (levels_.back().weight(0, 0) == 0) levels_.back().value(0, 0) = fallback;
  for (size_t l = levels_.size() - 1; l-- > 0;) {
    Level& fine = levels_[l];
    const cv::Mat coarse = Upsample(levels_[l + 1].value);
    tbb::parallel_for(0, fine.value.height(), [&](int y) {
      for (int x = 0; x < fine.value.width(); ++x) {
        if (fine.weight(x, y) == 0) fine.value(x, y) = coarse.at<float>(y, x);
      }
    });
  }
  const cv::Mat coarse = Upsample(levels_[0].value);
  tbb::parallel_for(0, height, [&](int y) {
    const float* gap = coarse.ptr<float>(y);
    for (int x = 0; x < width; ++x) {
      (*dense)(x, y) = sigma(x, y) > 0 ? inverse_virtual_depth(x, y) : gap[x];
    }
  });
}

}  // namespace prism
