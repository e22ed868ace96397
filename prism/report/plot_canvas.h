// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prism/report/plot.h"

namespace prism {

struct Color {
  int red = 0;  // 0 to 255
  int green = 0;
  int blue = 0;
};

enum class TextAnchor { kStart, kMiddle, kEnd };

// A white surface to draw on; x to the right, y down, in units of a screen pixel.
class PlotCanvas {
 public:
  PlotCanvas(int width, int height);
  ~PlotCanvas();
  PlotCanvas(const PlotCanvas&) = delete;
  PlotCanvas& operator=(const PlotCanvas&) = delete;

  void Polyline(const std::vector<PlotPoint>& points, Color color, double width);
  // `baseline`: where the anchor of the text stands. `vertical` text reads upwards.
  void Text(PlotPoint baseline,
            const std::string& text,
            TextAnchor anchor,
            double size,
            Color color,
            bool vertical);

  // Each writes the drawing whole or not at all, and throws InputError if that cannot be done. PDF
  // has its fonts inside and text that can be copied; SVG has their outlines, and its
  // texts once more as a description, for search and screen readers; PNG has twice the pixels each
  // way, for dense screens.
  void SavePdf(const std::string& path) const;
  void SaveSvg(const std::string& path) const;
  void SavePng(const std::string& path) const;

 private:
  struct Drawing;
  std::unique_ptr<Drawing> drawing_;
};

}  // namespace prism
