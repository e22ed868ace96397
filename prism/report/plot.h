// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace prism {

struct PlotPoint {
  double x = 0;
  double y = 0;
};

struct PlotSeries {
  std::string label;
  std::vector<PlotPoint> points;      // drawn in order, joined by lines; not finite: a gap
  bool is_reference = false;          // drawn in gray, behind the others (ground truth)
  std::vector<double> y_errors = {};  // half the length of a bar through each point; empty: none
};

// A line plot with two linear axes and a legend. With categories, x counts them: 0 is the first.
struct Plot {
  std::string title;
  std::string x_label;  // with unit
  std::string y_label;
  std::vector<PlotSeries> series;
  bool equal_scale = false;                    // one unit has one length on both axes (maps)
  bool y_from_zero = false;                    // the y axis includes 0
  bool legend_at_bottom = false;               // in the lower right corner, not the upper one
  std::vector<std::string> x_categories = {};  // their names stand on the x axis, not numbers
};

// Positions of axis ticks in [low, high]: multiples of 1, 2 or 5 times a power of ten, about
// `count` of them. high > low.
std::vector<double> AxisTicks(double low, double high, int count);

// Writes PATH_WITHOUT_EXTENSION.pdf, .svg and .png, the same drawing each. Throws InputError if
// that cannot be done. A plot without any finite point shows its axes from 0 to 1.
void WritePlot(const std::string& path_without_extension, const Plot& plot);

// The same with several plots on one page, row by row. columns > 0.
void WritePlotPage(const std::string& path_without_extension,
                   const std::vector<Plot>& plots,
                   int columns);

}  // namespace prism
