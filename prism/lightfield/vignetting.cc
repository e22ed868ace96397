// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/vignetting.h"

#include <algorithm>
#include <cmath>

#include "prism/image/interpolation.h"

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

}  // namespace

std::optional<Vignetting> EstimateVignetting(const LensTable& lenses,
                                             const std::vector<ImageF>& frames) {
  constexpr double kCentre = 0.4;                // of the radius
  constexpr double kDark = 8, kSaturated = 235;  // mean brightness that tells nothing
  constexpr int kMinMicroImages = 100;
  constexpr double kWhite = 40000;  // at the centre
  const int num_types = static_cast<int>(lenses.focus_of_type().size());
  const double radius = lenses.radius_px();
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  std::vector<Shading> shading(num_types, Shading(reach));
  std::vector<int> used(num_types, 0);
  for (const ImageF& frame : frames) {
    for (const Lens& lens : lenses.lenses()) {
      const double centre = CentralBrightness(frame, lens, reach, kCentre * radius);
      if (centre < kDark || centre > kSaturated) continue;
      ++used[lens.type];
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const double value =
              InterpolateBilinear(frame, lens.image_x + dx, lens.image_y + dy).value;
          shading[lens.type].Add(dx, dy, value / centre);
        }
      }
    }
  }
  Vignetting result;
  std::vector<ImageF> means;
  for (int type = 0; type < num_types; ++type) {
    if (used[type] < kMinMicroImages) return std::nullopt;
    result.micro_images += used[type];
    means.push_back(shading[type].Means());
    const double centre = MeanOnRing(means.back(), 0, kCentre * radius);
    result.rim =
        std::min(result.rim, MeanOnRing(means.back(), 0.8 * radius, 0.9 * radius) / centre);
  }
  result.white = cv::Mat::zeros(lenses.height(), lenses.width(), CV_16UC1);
  for (const Lens& lens : lenses.lenses()) {
    const ImageF& mean = means[lens.type];
    lenses.ForEachPixel(lens, [&](int x, int y) {
      const double u = x - lens.image_x + reach, v = y - lens.image_y + reach;
      if (!mean.view().Contains(u, v)) return;
      const double value = kWhite * InterpolateBilinear(mean, u, v).value;
      result.white.at<uint16_t>(y, x) = static_cast<uint16_t>(std::clamp(value, 0.0, 65535.0));
    });
  }
  return result;
}

}  // namespace prism
