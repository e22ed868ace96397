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

// A surface to draw on; x to the right, y down, in units of a screen pixel.
class PlotCanvas {
 public:
  virtual ~PlotCanvas() = default;
  virtual void Polyline(const std::vector<PlotPoint>& points, Color color, double width) = 0;
  // `baseline`: where the anchor of the text stands. `vertical` text reads upwards.
  virtual void Text(PlotPoint baseline,
                    const std::string& text,
                    TextAnchor anchor,
                    double size,
                    Color color,
                    bool vertical) = 0;
  // Writes the drawing, whole or not at all. Throws InputError if that cannot be done.
  virtual void Save(const std::string& path) const = 0;
};

std::unique_ptr<PlotCanvas> MakeSvgCanvas(int width, int height);
// Twice the pixels each way, for dense screens and print.
std::unique_ptr<PlotCanvas> MakePngCanvas(int width, int height);

}  // namespace prism
