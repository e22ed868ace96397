// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/procedural_texture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <glog/logging.h>
#include <opencv2/imgproc.hpp>

namespace prism {
namespace {

using Painter = std::function<cv::Mat(int, cv::RNG&)>;

// Sum of smoothed noise over scales from `coarsest` cells a side to a pixel, zero mean, the
// coarsest scale with amplitude 1 and each finer one with `persistence` of the one before.
cv::Mat FractalNoise(int pixels, cv::Size coarsest, double persistence, cv::RNG& rng) {
  cv::Mat sum(pixels, pixels, CV_32F, cv::Scalar(0));
  double amplitude = 1;
  for (cv::Size cells = coarsest; std::max(cells.width, cells.height) <= pixels;
       cells = cells * 2, amplitude *= persistence) {
    cv::Mat lattice(cells.height, cells.width, CV_32F);
    rng.fill(lattice, cv::RNG::UNIFORM, -amplitude, amplitude);
    cv::Mat fine;
    cv::resize(lattice, fine, sum.size(), 0, 0, cv::INTER_CUBIC);
    sum += fine;
  }
  return sum;
}

// Adds strength * noise to all three channels of an 8-bit image.
void AddNoise(cv::Mat* image, const cv::Mat& noise, double strength) {
  cv::Mat channels[3] = {noise, noise, noise};
  cv::Mat colour;
  cv::merge(channels, 3, colour);
  cv::Mat result;
  image->convertTo(result, CV_32F);
  result += colour * strength;
  result.convertTo(*image, CV_8U);
}

cv::Mat Flat(int pixels, const cv::Scalar& colour) { return {pixels, pixels, CV_8UC3, colour}; }

cv::Scalar Vary(const cv::Scalar& colour, double amount, cv::RNG& rng) {
  const double d = rng.uniform(-amount, amount);
  return {colour[0] + d, colour[1] + d, colour[2] + d};
}

// A colour of any brightness and moderate saturation.
cv::Scalar Colour(cv::RNG& rng) {
  const double gray = rng.uniform(60.0, 200.0);
  const double blue = rng.uniform(-50.0, 40.0);
  const double green = rng.uniform(-40.0, 40.0);
  const double red = rng.uniform(-40.0, 55.0);
  return {gray + blue, gray + green, gray + red};
}

cv::Mat Plaster(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {205, 212, 215});
  AddNoise(&image, FractalNoise(n, {3, 3}, 0.55, rng), 5);
  return image;
}

cv::Mat Wood(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {70, 105, 150});
  AddNoise(&image, FractalNoise(n, {2, 24}, 0.7, rng), 20);
  return image;
}

cv::Mat Planks(int n, cv::RNG& rng) {
  cv::Mat image(n, n, CV_8UC3);
  const int rows = 12;
  for (int row = 0; row < rows; ++row) {
    const int y0 = row * n / rows;
    const int y1 = (row + 1) * n / rows;
    int x = -rng.uniform(0, n / 2);
    while (x < n) {
      const int x1 = x + rng.uniform(n / 3, n / 2 + n / 4);
      cv::rectangle(image, {x, y0}, {x1, y1}, Vary({75, 115, 165}, 28, rng), cv::FILLED);
      cv::line(image, {x, y0}, {x, y1}, {25, 40, 60}, std::max(1, n / 512));
      x = x1;
    }
    cv::line(image, {0, y0}, {n, y0}, {25, 40, 60}, std::max(1, n / 512));
  }
  AddNoise(&image, FractalNoise(n, {4, 64}, 0.75, rng), 16);
  return image;
}

// Rectangles in courses, each of its own shade, with joints between them.
cv::Mat Courses(int n,
                int rows,
                int columns,
                bool staggered,
                const cv::Scalar& stone,
                const cv::Scalar& joint,
                double variation,
                cv::RNG& rng) {
  cv::Mat image = Flat(n, joint);
  const int gap = std::max(1, n / (rows * 14));
  for (int row = 0; row < rows; ++row) {
    const double shift = staggered && row % 2 == 1 ? 0.5 : 0.0;
    for (int column = -1; column <= columns; ++column) {
      const int x0 = static_cast<int>((column + shift) * n / columns);
      const int x1 = static_cast<int>((column + 1 + shift) * n / columns);
      cv::rectangle(image,
                    {x0 + gap, row * n / rows + gap},
                    {x1 - gap, (row + 1) * n / rows - gap},
                    Vary(stone, variation, rng),
                    cv::FILLED);
    }
  }
  return image;
}

cv::Mat Bricks(int n, cv::RNG& rng) {
  cv::Mat image = Courses(n, 12, 4, true, {70, 85, 150}, {165, 170, 175}, 30, rng);
  AddNoise(&image, FractalNoise(n, {16, 16}, 0.8, rng), 14);
  return image;
}

cv::Mat Tiles(int n, cv::RNG& rng) {
  cv::Mat image = Courses(n, 5, 5, false, {185, 195, 200}, {90, 95, 95}, 10, rng);
  AddNoise(&image, FractalNoise(n, {6, 6}, 0.7, rng), 12);
  return image;
}

cv::Mat Fabric(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, Vary({120, 95, 70}, 20, rng));
  for (int i = 0; i < 14; ++i) {
    const int at = rng.uniform(0, n);
    const int width = rng.uniform(2, n / 24 + 3);
    const cv::Scalar colour = Vary({150, 120, 90}, 60, rng);
    cv::Mat overlay = image.clone();
    cv::rectangle(overlay,
                  i % 2 == 0 ? cv::Point(at, 0) : cv::Point(0, at),
                  i % 2 == 0 ? cv::Point(at + width, n) : cv::Point(n, at + width),
                  colour,
                  cv::FILLED);
    cv::addWeighted(overlay, 0.6, image, 0.4, 0, image);
  }
  AddNoise(&image, FractalNoise(n, {64, 64}, 0.9, rng), 14);
  return image;
}

cv::Mat Rug(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {50, 40, 130});
  for (int ring = 0; ring < 7; ++ring) {
    const int inset = ring * n / 18;
    cv::rectangle(
        image, {inset, inset}, {n - inset, n - inset}, Vary({90, 100, 150}, 80, rng), cv::FILLED);
    const int step = std::max(8, n / 28);
    const cv::Scalar colour = Colour(rng);
    for (int at = inset + step / 2; at < n - inset; at += step) {
      const int r = n / 90 + 1;
      for (const cv::Point& center : {cv::Point(at, inset + n / 36),
                                      cv::Point(at, n - inset - n / 36),
                                      cv::Point(inset + n / 36, at),
                                      cv::Point(n - inset - n / 36, at)}) {
        cv::circle(image, center, r, colour, cv::FILLED, cv::LINE_AA);
      }
    }
  }
  AddNoise(&image, FractalNoise(n, {64, 64}, 0.85, rng), 12);
  return image;
}

cv::Mat Painting(int n, cv::RNG& rng) {
  // Sky, hills and houses in broad strokes.
  cv::Mat image(n, n, CV_8UC3);
  const int horizon = rng.uniform(n / 3, n / 2);
  for (int y = 0; y < n; ++y) {
    const double t = static_cast<double>(y) / n;
    image.row(y).setTo(cv::Scalar(220 - 80 * t, 180 - 30 * t, 140 + 60 * t));
  }
  for (int layer = 0; layer < 5; ++layer) {
    std::vector<cv::Point> hill{{0, n}};
    const double phase = rng.uniform(0.0, 6.0);
    const double waves = rng.uniform(3.0, 9.0);
    for (int x = 0; x <= n; x += std::max(1, n / 64)) {
      hill.emplace_back(
          x,
          horizon + layer * n / 9 + static_cast<int>(n / 16.0 * std::sin(phase + waves * x / n)));
    }
    hill.emplace_back(n, n);
    cv::fillPoly(image, std::vector<std::vector<cv::Point>>{hill}, Vary({60, 120, 90}, 55, rng));
    for (int house = 0; house < 4; ++house) {
      const cv::Point at(rng.uniform(0, n), horizon + layer * n / 9 + rng.uniform(0, n / 10));
      const int size = n / 40 + rng.uniform(0, n / 24);
      cv::rectangle(image, at, at + cv::Point(size, size), Colour(rng), cv::FILLED);
      const std::vector<cv::Point> roof{
          at, at + cv::Point(size, 0), at + cv::Point(size / 2, -size / 2)};
      cv::fillConvexPoly(image, roof, {40, 40, rng.uniform(90.0, 200.0)}, cv::LINE_AA);
    }
  }
  AddNoise(&image, FractalNoise(n, {8, 8}, 0.7, rng), 16);
  const int frame = n / 18;
  cv::rectangle(image, {0, 0}, {n - 1, n - 1}, {30, 45, 60}, 2 * frame);
  cv::rectangle(image, {frame, frame}, {n - frame, n - frame}, {150, 190, 200}, frame / 4 + 1);
  return image;
}

cv::Mat Poster(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {225, 228, 230});
  cv::rectangle(image, {n / 12, n / 12}, {n - n / 12, n / 3}, Colour(rng), cv::FILLED);
  cv::circle(image, {n / 2, n / 5}, n / 10, Colour(rng), cv::FILLED, cv::LINE_AA);
  int y = n / 3 + n / 20;
  while (y < n - n / 10) {
    const int height = rng.uniform(n / 90 + 2, n / 34 + 3);
    int x = n / 12;
    const int end = n - n / 12 - rng.uniform(0, n / 4);
    while (x < end) {  // words of strokes
      const int word = rng.uniform(n / 40, n / 10);
      for (int stroke = x; stroke < std::min(x + word, end); stroke += height / 2 + 2) {
        cv::line(image,
                 {stroke, y + rng.uniform(0, height / 2)},
                 {stroke + rng.uniform(-height / 3, height / 3 + 1), y + height},
                 {40, 35, 35},
                 std::max(1, height / 6),
                 cv::LINE_AA);
      }
      x += word + height;
    }
    y += 2 * height;
  }
  AddNoise(&image, FractalNoise(n, {32, 32}, 0.7, rng), 4);
  return image;
}

cv::Mat Books(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {20, 25, 30});
  int x = 0;
  while (x < n) {
    const int width = rng.uniform(n / 40 + 2, n / 16 + 3);
    const int top = rng.uniform(0, n / 5);
    const cv::Scalar cover = Colour(rng);
    cv::rectangle(image, {x, top}, {x + width - 2, n}, cover, cv::FILLED);
    const cv::Scalar print = cover[1] > 120 ? cv::Scalar(30, 30, 30) : cv::Scalar(210, 220, 225);
    const int band = top + rng.uniform(n / 12, n / 5);
    cv::rectangle(image, {x, band}, {x + width - 2, band + n / 60 + 1}, print, cv::FILLED);
    for (int y = band + n / 14; y < n - n / 8; y += n / 48 + 1) {
      if (rng.uniform(0, 5) == 0) y += n / 24;
      const int inset = width / 4 + 1;
      cv::line(image,
               {x + inset + rng.uniform(0, inset), y},
               {x + width - inset, y + rng.uniform(0, n / 90 + 1)},
               print,
               std::max(1, n / 160));
    }
    x += width;
  }
  AddNoise(&image, FractalNoise(n, {64, 64}, 0.7, rng), 6);
  return image;
}

cv::Mat Leaves(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {25, 60, 35});
  for (int i = 0; i < 900; ++i) {
    cv::ellipse(image,
                {rng.uniform(0, n), rng.uniform(0, n)},
                {n / 30 + rng.uniform(0, n / 30 + 1), n / 90 + 1},
                rng.uniform(0.0, 180.0),
                0,
                360,
                Vary({50, 130, 70}, 45, rng),
                cv::FILLED,
                cv::LINE_AA);
  }
  return image;
}

cv::Mat Asphalt(int n, cv::RNG& rng) {
  cv::Mat image = Flat(n, {105, 105, 105});
  AddNoise(&image, FractalNoise(n, {4, 4}, 0.9, rng), 10);
  for (int i = 0; i < 12; ++i) {
    const cv::Point a(rng.uniform(0, n), rng.uniform(0, n));
    const cv::Point b = a + cv::Point(rng.uniform(-n / 4, n / 4), rng.uniform(-n / 4, n / 4));
    cv::line(image, a, b, {50, 50, 50}, std::max(1, n / 400), cv::LINE_AA);
  }
  return image;
}

const std::map<std::string, Painter>& Painters() {
  static const auto* painters =
      new std::map<std::string, Painter>{{"plaster", Plaster},
                                         {"planks", Planks},
                                         {"bricks", Bricks},
                                         {"tiles", Tiles},
                                         {"wood", Wood},
                                         {"fabric", Fabric},
                                         {"rug", Rug},
                                         {"painting", Painting},
                                         {"poster", Poster},
                                         {"books", Books},
                                         {"leaves", Leaves},
                                         {"asphalt", Asphalt},
                                         {"white", [](int n, cv::RNG&) {
                                            return Flat(n, {255, 255, 255});
                                          }}};
  return *painters;
}

}  // namespace

const std::vector<std::string>& ProceduralTextureKinds() {
  static const auto* kinds = [] {
    auto* names = new std::vector<std::string>;
    for (const auto& [name, painter] : Painters()) names->push_back(name);
    return names;
  }();
  return *kinds;
}

cv::Mat MakeTexture(const std::string& kind, int pixels, uint64_t seed) {
  const auto painter = Painters().find(kind);
  CHECK(painter != Painters().end()) << kind;
  CHECK_GE(pixels, 16);
  cv::RNG rng(seed * 0x9e3779b97f4a7c15ull + 1);
  return painter->second(pixels, rng);
}

}  // namespace prism
