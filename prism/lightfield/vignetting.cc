// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/vignetting.h"

#include <algorithm>
#include <cmath>

#include "prism/image/interpolation.h"
#include "prism/lightfield/grid_estimation.h"

namespace prism {
namespace {

// Brightness over that of the centre, by place in the micro image.
class Shading {
 public:
  explicit Shading(int reach)
      : reach_(reach), side_(2 * reach + 1), counts_(side_ * side_ * kBins, 0) {}

  void Add(int dx, int dy, double ratio) {
    const int bin = std::clamp(static_cast<int>(ratio / kStep), 0, kBins - 1);
    ++counts_[static_cast<size_t>(Index(dx, dy)) * kBins + bin];
  }

  // Mean between the quartiles; 0 where nothing was added.
  ImageF Means() const {
    ImageF means(side_, side_, 0);
    for (int dy = -reach_; dy <= reach_; ++dy) {
      for (int dx = -reach_; dx <= reach_; ++dx) {
        const int* counts = &counts_[static_cast<size_t>(Index(dx, dy)) * kBins];
        means(dx + reach_, dy + reach_) = static_cast<float>(MeanBetweenQuartiles(counts));
      }
    }
    return means;
  }

 private:
  static constexpr int kBins = 256;
  static constexpr double kStep = 2.0 / kBins;

  int Index(int dx, int dy) const { return (dy + reach_) * side_ + dx + reach_; }

  static double MeanBetweenQuartiles(const int* counts) {
    double total = 0;
    for (int bin = 0; bin < kBins; ++bin) total += counts[bin];
    double below = 0, sum = 0, weight = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      const double from = std::max(below, 0.25 * total);
      below += counts[bin];
      const double inside = std::max(std::min(below, 0.75 * total) - from, 0.0);
      sum += inside * (bin + 0.5) * kStep;
      weight += inside;
    }
    return weight > 0 ? sum / weight : 0;
  }

  int reach_, side_;
  std::vector<int> counts_;
};

// Mean brightness around the centre; 0 for a micro image that does not lie within the frame.
double CentralBrightness(const ImageF& frame, const Lens& lens, int reach, double radius) {
  if (!frame.view().Contains(lens.image_x, lens.image_y, reach + 1)) return 0;
  double sum = 0;
  int count = 0;
  const int inner = static_cast<int>(radius);
  for (int dy = -inner; dy <= inner; ++dy) {
    for (int dx = -inner; dx <= inner; ++dx) {
      if (std::hypot(dx, dy) > radius) continue;
      sum += InterpolateBilinear(frame, lens.image_x + dx, lens.image_y + dy).value;
      ++count;
    }
  }
  return sum / count;
}

// The image in side x side regions: the main lens shades micro images at the border from one side.
class Regions {
 public:
  Regions(const LensTable& lenses, int side)
      : width_(static_cast<float>(lenses.width())),
        height_(static_cast<float>(lenses.height())),
        side_(side) {}

  int size() const { return side_ * side_; }

  int Nearest(const Lens& lens) const {
    const auto index = [this](float position, float length) {
      return std::clamp(static_cast<int>(position / length * side_), 0, side_ - 1);
    };
    return index(lens.image_y, height_) * side_ + index(lens.image_x, width_);
  }

  // Of the means of all regions, bilinear between their centres.
  ImageF Blend(const Lens& lens, const ImageF* means) const {
    ImageF blend(means->width(), means->height(), 0);
    const float fx = std::clamp(lens.image_x / width_ * side_ - 0.5f, 0.0f, side_ - 1.0f);
    const float fy = std::clamp(lens.image_y / height_ * side_ - 0.5f, 0.0f, side_ - 1.0f);
    for (int row = 0; row < side_; ++row) {
      for (int column = 0; column < side_; ++column) {
        const float weight =
            std::max(1 - std::abs(fx - column), 0.0f) * std::max(1 - std::abs(fy - row), 0.0f);
        if (weight == 0) continue;
        const ImageF& mean = means[row * side_ + column];
        for (size_t i = 0; i < blend.size(); ++i) blend.data()[i] += weight * mean.data()[i];
      }
    }
    return blend;
  }

 private:
  float width_, height_;
  int side_;
};

double MeanOnRing(const ImageF& shading, double inner, double outer) {
  const int reach = shading.width() / 2;
  double sum = 0;
  int count = 0;
  for (int y = 0; y < shading.height(); ++y) {
    for (int x = 0; x < shading.width(); ++x) {
      const double distance = std::hypot(x - reach, y - reach);
      if (distance < inner || distance > outer) continue;
      sum += shading(x, y);
      ++count;
    }
  }
  return count > 0 ? sum / count : 1;
}

std::optional<Vignetting> EstimateInRegions(const LensTable& lenses,
                                            const std::vector<cv::Mat>& frames,
                                            int side,
                                            int min_micro_images) {
  constexpr double kCentre = 0.4;                // of the radius
  constexpr double kDark = 8, kSaturated = 235;  // mean brightness that tells nothing
  const int num_types = static_cast<int>(lenses.focus_of_type().size());
  const double radius = lenses.radius_px();
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  const Regions regions(lenses, side);
  std::vector<Shading> shading(static_cast<size_t>(num_types) * regions.size(), Shading(reach));
  std::vector<int> used(shading.size(), 0);
  for (const cv::Mat& image : frames) {
    const ImageF frame = MeanImage({image});  // one at a time: that of a large sensor takes 130 MB
    for (const Lens& lens : lenses.lenses()) {
      const double centre = CentralBrightness(frame, lens, reach, kCentre * radius);
      if (centre < kDark || centre > kSaturated) continue;
      const int part = lens.type * regions.size() + regions.Nearest(lens);
      ++used[part];
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const double value =
              InterpolateBilinear(frame, lens.image_x + dx, lens.image_y + dy).value;
          shading[part].Add(dx, dy, value / centre);
        }
      }
    }
  }
  Vignetting result;
  std::vector<ImageF> means;
  for (size_t part = 0; part < shading.size(); ++part) {
    if (used[part] < min_micro_images) return std::nullopt;
    result.micro_images += used[part];
    means.push_back(shading[part].Means());
    const double centre = MeanOnRing(means.back(), 0, kCentre * radius);
    result.rim =
        std::min(result.rim, MeanOnRing(means.back(), 0.8 * radius, 0.9 * radius) / centre);
  }
  result.white = cv::Mat::zeros(lenses.height(), lenses.width(), CV_16UC1);
  for (const Lens& lens : lenses.lenses()) {
    const ImageF mean =
        regions.Blend(lens, &means[static_cast<size_t>(lens.type) * regions.size()]);
    lenses.ForEachPixel(lens, [&](int x, int y) {
      constexpr double kWhite = 40000;  // at the centre
      const double u = x - lens.image_x + reach, v = y - lens.image_y + reach;
      if (!mean.view().Contains(u, v)) return;
      const double value = kWhite * InterpolateBilinear(mean, u, v).value;
      result.white.at<uint16_t>(y, x) = static_cast<uint16_t>(std::clamp(value, 0.0, 65535.0));
    });
  }
  return result;
}

}  // namespace

std::optional<Vignetting> EstimateVignetting(const LensTable& lenses,
                                             const std::vector<cv::Mat>& frames) {
  constexpr int kMany = 400, kFew = 100;  // micro images of a type in a region, over all frames
  for (const int side : {3, 2}) {
    if (auto vignetting = EstimateInRegions(lenses, frames, side, kMany)) return vignetting;
  }
  return EstimateInRegions(lenses, frames, 1, kFew);
}

}  // namespace prism
